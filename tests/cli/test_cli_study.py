"""``glimt study`` as users run it: the whole of it on the stone room, its report in a browser, Ctrl-C, mistakes."""

import io
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from chromium import chromium, needs_chromium
from glimt.cli.progress import TimeLeft
from glimt.study.experiments import FIGURES
from glimt.study.results import read, schema

COMMAND = [sys.executable, "-m", "glimt", "study"]


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Return the folder of a quick study of the stone room with brute force, and what was printed."""
    folder = tmp_path_factory.mktemp("study")
    done = subprocess.run([*COMMAND, "--quick", "--brute-force", "--engine", "cpu", "--seconds", "0.3"], cwd=folder,
                          capture_output=True, text=True, encoding="utf-8", timeout=600)
    assert done.returncode == 0, done.stderr
    return folder / "study-stone_room", done


def test_the_whole_study_leaves_report_numbers_and_figures(studied):
    folder, done = studied
    names = {f"figure-{number}-{kind.name}.png" for number, kind in FIGURES.items()}
    assert {file.name for file in folder.iterdir()} == {"report.html", "results.json"} | names
    assert done.stdout.endswith("the report is study-stone_room/report.html\n")
    assert "about" in done.stderr
    assert "Traceback" not in done.stderr


def test_laws_that_no_noise_can_hide(studied):
    """Brute force costs about as many times as much as there are triangles; trees hardly notice."""
    result = read(studied[0] / "results.json")
    exponents = {series.name: series.fitted("power").numbers["exponent"].value
                 for series in result.figure(6).series if series.fitted("power")}
    assert exponents["cut finer, brute force"] > 0.75
    assert exponents["the same surfaces cut finer"] < 0.35
    bounces = {series.name: series for series in result.figure(4).series}
    mirrors = bounces["every surface a mirror"].points
    assert mirrors[-1].rays.mirror > 8 * mirrors[0].rays.primary
    lights = result.figure(5).series[0]
    assert lights.fitted("linear").r2 > 0.8
    assert all(point.stages_ms for point in result.figure(10).series[0].points)
    assert result.command.startswith("glimt study --quick --brute-force")
    assert result.machine.cores == os.cpu_count()


@needs_chromium
def test_the_report_in_a_browser(studied):
    """Every figure is there and drawn, nothing complains, and nothing sticks out on a telephone or a desktop."""
    complaints = []
    with chromium() as browser:
        page = browser.new_page()
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: complaints.append(request.url)
                if not request.url.startswith(("file:", "data:")) else None)
        for width, height in ((390, 844), (1280, 800)):
            page.set_viewport_size({"width": width, "height": height})
            page.goto((studied[0] / "report.html").as_uri())
            sizes = page.evaluate("[...document.images].map(i => [i.complete, i.naturalWidth, i.clientWidth])")
            assert len(sizes) == len(FIGURES)
            assert all(complete and natural > 0 and 300 < shown <= width for complete, natural, shown in sizes)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.locator("section").count() == len(FIGURES)
            page.locator("summary").first.click()
            assert page.locator("table").first.is_visible()
        assert page.evaluate("getComputedStyle(document.body).fontSize") == "16px"
    assert complaints == []


def test_going_on_with_a_finished_study_measures_nothing(studied):
    folder, _ = studied
    before = (folder / "results.json").read_text()
    start = time.monotonic()
    done = subprocess.run([*COMMAND, "--quick", "--brute-force", "--engine", "cpu", "--resume"], cwd=folder.parent,
                          capture_output=True, text=True, encoding="utf-8", timeout=600)
    assert done.returncode == 0, done.stderr
    assert json.loads(before)["figures"] == json.loads((folder / "results.json").read_text())["figures"]
    assert "figure 3" not in done.stderr
    assert time.monotonic() - start < 60


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path):
    process = subprocess.Popen([*COMMAND, "--engine", "cpu", "--figures", "3,6", "--quick", "--seconds", "3"],
                               cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               encoding="utf-8", preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    for line in process.stderr:
        if line.startswith("figure 6"):  # which takes some seconds to make its scenes
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            break
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert "interrupted: study-stone_room keeps what is done; go on with --resume" in err
    assert "Traceback" not in err
    assert "figure 3, pixels" in out
    assert read(tmp_path / "study-stone_room" / "results.json").figures[0].complete
    assert (tmp_path / "study-stone_room" / "report.html").is_file()


def test_ctrl_c_while_the_report_is_written(glimt, monkeypatch):
    from glimt.study import output

    def interrupted(folder, result):
        raise KeyboardInterrupt

    arguments = "study", "ball.toml", "--figures", "7", "--quick", "--seconds", "0.1", "--engine", "cpu"
    with monkeypatch.context() as patch:
        patch.setattr(output, "write_report", interrupted)
        done = glimt(*arguments)
    assert done.code == 130
    assert done.err.endswith("interrupted: study-ball keeps the numbers; --resume writes the report\n")
    assert not os.path.exists("study-ball/report.html")
    assert glimt(*arguments, "--resume").code == 0
    assert os.path.exists("study-ball/report.html")


def test_comparing_two_results(glimt, studied, tmp_path):
    path = studied[0] / "results.json"
    other = tmp_path / "later.json"
    other.write_text(path.read_text())
    done = glimt("study", "--compare", str(path), str(other), "-o", "both")
    assert (done.code, done.out, done.err) == (0, "the report is both/report.html\n", "")
    assert "<h1>results and later</h1>" in (tmp_path / "both" / "report.html").read_text()


def test_the_schema(glimt):
    assert glimt("study", "--schema").out == schema()


@pytest.mark.parametrize(("arguments", "message"), [
    (["nix.toml"], "error: nix.toml: no such file"),
    (["--figures", "1"], "error: there is no figure '1'; expected some of 2, 3, 4, 5, 6, 7, 8, 9, 10"),
    (["--compare", "a.json", "b.json"], "error: a.json: cannot be read as a result of a study"),
])
def test_mistakes_are_told_in_a_line(glimt, arguments, message):
    done = glimt("study", *arguments)
    assert done.code == 1
    assert done.err.splitlines()[-1].startswith(message)


def test_without_matplotlib(glimt, monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("matplotlib", "glimt.study"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = glimt("study", "ball.toml")
    assert (done.code, done.err) == (1, "error: this needs the package matplotlib: pip install 'glimt[study]'\n")
    assert not any(name.startswith("study") for name in os.listdir())


def test_without_the_example(glimt, monkeypatch):
    from glimt.io import example
    monkeypatch.setattr(example, "_FOLDERS", ())
    done = glimt("study")
    assert (done.code, done.err) == (1, "error: the example stone_room.toml is not part of this installation; name a "
                                        "scene file\n")


class Terminal(io.StringIO):
    """Where a person watches."""

    def isatty(self):
        return True


def test_a_terminal_shows_a_bar_with_the_time_left(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(sys, "stderr", Terminal())
    with TimeLeft() as left:
        left("figure 3: pixels", 0.25, 240.0)
        time.sleep(0.15)
        left("figure 4: bounces", 0.5, 42.0)
    shown = sys.stderr.getvalue()
    assert "figure 3: pixels, about 4 min left" in shown
    assert "figure 4: bounces, about 42 s left" in shown
    assert "50%" in shown


def test_elsewhere_a_line_tells_of_each_figure(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with TimeLeft() as left:
        for share in (0.0, 0.1, 0.2):
            left("figure 3: pixels", share, 99.0)
    assert sys.stderr.getvalue() == "figure 3: pixels, about 99 s left\n"
