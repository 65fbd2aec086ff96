"""What visitors of the viewer's server may send, and what they are sent."""

import asyncio
import contextlib
import struct

import numpy as np
import pytest
import simplejpeg
import websockets
from web_client import SIZE, answers_still, connect_raw, fill, visit
from web_host import WebHost

from glimt.viewer.web.canvas import WebCanvas
from glimt.viewer.web.visitor import Visitor


@pytest.fixture(scope="module")
def host():
    with WebHost() as host:
        yield host


def test_frames_come_small_and_once_more_without_loss(host):
    async def run():
        async with visit(host) as client:
            await client.send(SIZE)
            for subsampling in ("420", "444"):
                frame = await client.wait_for("framebufferdata")
                assert simplejpeg.decode_jpeg_header(frame["data"])[:4] == (100, 160, "YCbCr", subsampling)
            await client.drain(0.5)
            assert len(client.frames) == 2

    asyncio.run(run())


def test_unknown_and_damaged_messages_are_ignored(host):
    key = {"type": "key_down", "key": "k", "modifiers": []}
    pointer = {"type": "pointer_move", "x": 1, "y": 2, "button": 0, "buttons": [], "modifiers": []}
    bad = ["", "{", "null", "[]", "7", '"text"', "[" * 30_000, "{}", '{"type": 7}', '{"type": null}', "\0", b"\xff\x00",
           '{"type": "pointer_move", "x": NaN, "y": 1}',
           '{"type": "resize", "pwidth": 1e999, "pheight": 1, "ratio": 1}',
           *('{"type": "_framefeedback", "index": ' + "9" * digits + "}" for digits in (20, 400, 5000))]
    bad += [{"type": kind} for kind in ("close", "before_draw", "animate", "char", "_clients_change", "show", "resize",
                                        "key_down", "wheel", "pointer_down", "_framefeedback", "fullscreen", "")]
    bad += [{**key, "key": value} for value in (7, None, "", "x" * 33, "\ud800", "\n", ["k"], {})]
    bad += [{**pointer, "x": value} for value in (None, "1", True, 1e300, [], {})]
    bad += [{**SIZE, name: value} for name in ("pwidth", "pheight", "ratio")
            for value in (0, -5, None, "9", True, 1e300, [])]
    bad += [{"type": "_framefeedback", "index": value} for value in (None, -1, 1e300, "1", [])]

    async def run():
        async with visit(host) as client:
            await client.send(SIZE)
            start = len(host.said)
            for message in bad:
                await client.send(message)
            await client.send(pointer, buttons=[1, 1, 9, None, {}], modifiers=[{}, "Shift", "x"], button=1e9)
            await client.key("end")
            await asyncio.to_thread(host.wait_for_event, "key_down", start, key="end")
            return [event for event in host.events(start) if event["event_type"] != "resize"]

    move, key_down = asyncio.run(run())[:2]
    assert (move["event_type"], key_down["event_type"]) == ("pointer_move", "key_down")
    assert (move["buttons"], move["modifiers"], move["button"]) == ([1], ["Shift"], 0)


def test_a_size_beyond_all_screens_is_made_smaller(host):
    async def run():
        async with visit(host) as client:
            start = len(host.said)
            await client.send({**SIZE, "pwidth": 500_000, "pheight": 250_000, "ratio": 2})
            return await asyncio.to_thread(host.wait_for_event, "resize", start)

    event = asyncio.run(run())
    assert event["width"] == pytest.approx(250_000, rel=1e-3)  # logical size stays
    assert event["width"] * event["height"] * event["pixel_ratio"] ** 2 <= 4096 ** 2


def test_a_message_too_large_ends_its_sender_only(host):
    async def run():
        async with visit(host) as other, visit(host) as client:
            await client.send("x" * 100_000)
            with pytest.raises(websockets.ConnectionClosed):
                await client.drain(5)
            await other.send(SIZE)
            await other.wait_for("framebufferdata")

    asyncio.run(run())


def test_a_flood_is_read_more_slowly_and_nothing_is_lost(host):
    async def run():
        async with visit(host) as client:
            start = len(host.said)
            for number in range(1500):
                await client.key(str(number), "key_up")
            await answers_still(host)
            await asyncio.to_thread(host.wait_for_event, "key_up", start, key="1499")
            return [event["key"] for event in host.events(start) if event["event_type"] == "key_up"]

    assert asyncio.run(run()) == [str(number) for number in range(1500)]


def serve_visitor(seconds, receive, send, prepare=lambda visitor: None):
    """Serve a visitor for a while, without a network; return how many messages have been taken from it."""
    taken = []

    async def run():
        visitor = Visitor()
        prepare(visitor)
        async with asyncio.timeout(seconds):
            await visitor.run(receive, send, taken.append)

    with contextlib.suppress(TimeoutError):
        asyncio.run(run())
    return len(taken)


def test_no_more_is_read_than_anybody_could_do():
    async def receive():
        return {"type": "websocket.receive", "text": "{}"}

    async def send(message):
        pass

    assert 0 < serve_visitor(0.4, receive, send) < 1000  # in two quarters of a second


def test_who_is_too_slow_for_messages_is_sent_away():
    sent = []

    async def never():
        await asyncio.Event().wait()

    async def send(message):
        sent.append(message)

    def post(count):
        return lambda visitor: [visitor.post({"type": "cursor", "value": "none"}) for _ in range(count)]

    serve_visitor(0.05, never, send, post(64))
    assert [message["type"] for message in sent] == ["websocket.send"] * 64
    sent.clear()
    serve_visitor(5, never, send, post(65))
    assert sent == [{"type": "websocket.close", "code": 1013}]


def test_pings_are_not_read_faster_than_their_answers(host):
    with connect_raw(host) as raw:
        fill(raw)
        with pytest.raises(TimeoutError):  # stuck, since the answers are not read
            raw.send(bytes(1))
    asyncio.run(answers_still(host))


def test_a_message_in_endless_parts_ends_its_sender(host):
    with connect_raw(host) as raw:
        raw.settimeout(3)  # before the server's first ping
        raw.sendall(b"\x01\x80\0\0\0\0" + 2000 * b"\x00\x80\0\0\0\0")  # a text without end, in empty parts
        with contextlib.suppress(ConnectionResetError):
            while raw.recv(4096):
                pass
    asyncio.run(answers_still(host))


def test_who_does_not_read_gets_no_more_and_then_the_newest():
    async def run(host):
        async with visit(host) as fast, visit(host) as slow:
            for client in (fast, slow):
                await client.send(SIZE)
            await slow.send(type="_framefeedback", index=10**9)  # it has not been sent any
            for _ in range(20):
                await fast.wait_for("framebufferdata")
                await fast.confirm()
            await slow.drain()
            assert [frame["index"] for frame in slow.frames] == [1, 2]
            await slow.confirm()
            await slow.drain()
            assert [frame["index"] for frame in slow.frames] == [1, 2, 3, 4]
            assert slow.frames[2]["data"] not in [frame["data"] for frame in fast.frames[:15]]

    with WebHost("--moving") as host:
        asyncio.run(run(host))


def test_the_first_visitor_steers_and_the_next_takes_over(host):
    async def run():
        async with visit(host) as second_to_come:
            async with visit(host) as first:
                pass  # whoever comes and goes
            del first
            async with visit(host) as watcher:
                await second_to_come.send(SIZE)
                await watcher.wait_for("active", value=False)
                await watcher.send({**SIZE, "pwidth": 640})
                await watcher.key("ignored")
                await second_to_come.key("w")
                await second_to_come.send(type="pointer_down", x=3, y=4, button=1, buttons=[1], modifiers=[])
                await asyncio.to_thread(host.wait_for_event, "pointer_down", start)
                before = host.events(start)
                taken_over = len(host.said)
                await second_to_come.ws.close()
                await watcher.wait_for("active", value=True)
                await watcher.key("mine")
                await asyncio.to_thread(host.wait_for_event, "key_down", taken_over, key="mine")
                return before, host.events(taken_over)

    start = len(host.said)
    before, after = asyncio.run(run())
    assert "ignored" not in [event.get("key") for event in before]
    assert 640 not in [event.get("width") for event in before]
    assert [(event["event_type"], event.get("key")) for event in after] == [
        ("key_up", "w"), ("pointer_up", None), ("resize", None), ("key_down", "mine")]
    assert (after[1]["x"], after[1]["button"], after[1]["buttons"]) == (3, 1, [])
    assert after[2]["width"] == 640


def test_there_is_room_for_sixteen(host):
    async def run():
        clients = [visit(host) for _ in range(16)]
        for client in clients:
            await client.__aenter__()
        with pytest.raises(websockets.InvalidStatus):
            await answers_still(host)
        for client in clients:
            await client.__aexit__(None, None, None)
        await answers_still(host)

    asyncio.run(run())


def test_nothing_is_drawn_for_nobody():
    with WebHost("--moving") as host:
        assert host.ask()["draws"] == 0

        async def run():
            async with visit(host) as client:
                await client.drain()
                assert host.ask()["draws"] == 0  # it has not said how large it is
                await client.send(SIZE)
                await client.wait_for("framebufferdata")

        asyncio.run(run())
        draws = host.wait_until_alone()
        assert draws > 0
        asyncio.run(asyncio.sleep(0.3))
        assert host.ask()["draws"] == draws


@pytest.mark.parametrize("reads", [True, False])
def test_a_visitor_that_falls_silent_is_forgotten(reads):
    with WebHost("--ping", "0.3") as host, connect_raw(host) as silent:
        text = b'{"type": "key_down", "key": "w"}'
        silent.sendall(struct.pack("!BB4s", 0x81, 0x80 | len(text), bytes(4)) + text)
        host.wait_for_event("key_down", key="w")
        if not reads:
            with contextlib.suppress(ConnectionError):
                fill(silent)
        host.wait_for_event("key_up", key="w")  # though it has sent none
        assert host.ask()["visitors"] == 0


def test_a_finer_frame_that_comes_too_late_is_dropped():
    canvas = WebCanvas()
    dark, bright = (np.full((64, 64, 4), value, np.uint8) for value in (20, 200))

    async def run():
        canvas._rc_present_bitmap(data=dark, format="rgba-u8")
        canvas._refine(canvas._picture)
        canvas._rc_present_bitmap(data=bright, format="rgba-u8")
        await asyncio.sleep(0.1)

    asyncio.run(run())
    assert simplejpeg.decode_jpeg(canvas._frame.data).min() > 190
    canvas.close()
