// What is done with mouse, pen, fingers and keys, as events of rendercanvas' event spec.

const MODIFIERS = ["Alt", "Control", "Meta", "Shift"];
const LEFT = 1, MIDDLE = 4; // bits of PointerEvent.buttons
const TAP_DISTANCE = 8, DOUBLE_TAP_DISTANCE = 40; // px
const DOUBLE_TAP_TIME = 350; // ms
const WHEEL_PER_DOUBLING = 500; // px of a wheel, 100 a notch, for fingers twice as far apart
const WHEEL_SCALE = [1, 100 / 3, 600]; // px in a pixel, line and page of WheelEvent.deltaMode: three lines are a notch
const BROWSER_KEYS = ["F5", "F12", "Dead", "Process", "Unidentified"]; // reload, developer tools, parts of other keys

const modifiersOf = (ev) => MODIFIERS.filter((name) => ev?.getModifierState?.(name));
const timestamp = () => performance.now() / 1000;

// Sends events of `view` through `send` from now on. Returns what the server may ask for.
export function watchInput(view, send) {
  const output = inOrder(send);
  const keys = watchKeys(output);
  const pointer = watchPointer(view, output);
  const lock = watchPointerLock(view, pointer, send, keys);
  const fullscreen = watchFullscreen(send);
  for (const gesture of ["pointerdown", "pointerup", "keydown"]) {
    window.addEventListener(gesture, () => { lock.attempt(); fullscreen.attempt(); });
  }
  const release = () => { keys.release(); pointer.release(); };
  window.addEventListener("blur", release);
  return {release, setPointerLock: lock.set, setFullscreen: fullscreen.set};
}

// Moves and wheels may come a thousand times a second: the first one in a frame of the screen goes out at once, the
// others together at its end, and always before what comes after them.
function inOrder(send) {
  let waiting = null, frame = 0;
  const flush = () => {
    if (waiting) send(waiting);
    waiting = null;
  };
  const now = (event) => { flush(); send(event); };
  const soon = (event) => {
    const same = (name) => String(waiting[name]) === String(event[name]);
    if (waiting && !["type", "buttons", "modifiers"].every(same)) flush();
    if (waiting && event.type === "wheel") { event.dx += waiting.dx; event.dy += waiting.dy; }
    waiting = event;
    if (!frame) {
      flush();
      frame = requestAnimationFrame(() => { frame = 0; flush(); });
    }
  };
  return {now, soon};
}

function watchKeys(output) {
  const down = new Map(); // places on the keyboard → keys as they were sent, for Shift may change in between
  const place = (ev) => ev.code || ev.key;
  const send = (type, key, ev) => output.now({type, key, modifiers: modifiersOf(ev), timestamp: timestamp()});
  const release = () => {
    for (const key of down.values()) send("key_up", key);
    down.clear();
  };
  const isBrowsers = (ev) => ev.isComposing || BROWSER_KEYS.includes(ev.key) ||
    ((ev.ctrlKey || ev.metaKey) && !["Control", "Meta"].includes(ev.key) && !ev.getModifierState("AltGraph"));

  window.addEventListener("keydown", (ev) => {
    if (isBrowsers(ev)) return;
    ev.preventDefault();
    if (down.has(place(ev))) return; // repeated
    down.set(place(ev), ev.key);
    send("key_down", ev.key, ev);
  }, {capture: true});
  window.addEventListener("keyup", (ev) => {
    if (!down.has(place(ev))) return;
    ev.preventDefault();
    send("key_up", down.get(place(ev)), ev);
    down.delete(place(ev));
    if (ev.key === "Meta") release(); // while it is down, macOS tells of no other key that comes up
  }, {capture: true});
  return {release, isDown: (key) => [...down.values()].includes(key)};
}

function watchPointer(view, output) {
  const pointer = {x: 0, y: 0, held: 0, isLocked: false};
  const buttons = () => [1, 2, 3, 4, 5].filter((button) => pointer.held & (1 << (button - 1)));
  const event = (type, ev, button = 0) => ({type, x: pointer.x, y: pointer.y, button, buttons: buttons(),
    modifiers: modifiersOf(ev), ntouches: 0, touches: {}, timestamp: timestamp()});
  pointer.send = (type, ev, button) => output.now(event(type, ev, button));
  pointer.move = (x, y, ev) => {
    [pointer.x, pointer.y] = [x, y];
    output.soon(event("pointer_move", ev, buttons()[0]));
  };
  pointer.wheel = (dx, dy, ev) => output.soon({type: "wheel", x: pointer.x, y: pointer.y, dx, dy, buttons: buttons(),
    modifiers: modifiersOf(ev), timestamp: timestamp()});
  pointer.hold = (held, ev) => {
    for (let button = 1; button <= 5; button++) {
      const bit = 1 << (button - 1);
      if (!((held ^ pointer.held) & bit)) continue;
      pointer.held ^= bit;
      pointer.send(held & bit ? "pointer_down" : "pointer_up", ev, button);
    }
  };
  pointer.release = () => pointer.hold(0);

  const touch = watchTouch(pointer);
  let isTouch = false; // the last thing to come down; "dblclick" does not say
  const follow = (ev) => {
    if (ev.pointerType === "touch") return touch(ev);
    const ends = ["pointercancel", "lostpointercapture"].includes(ev.type);
    if (!ends) [pointer.x, pointer.y] =
      pointer.isLocked ? [pointer.x + ev.movementX, pointer.y + ev.movementY] : [ev.clientX, ev.clientY];
    const held = ends ? 0 : ev.buttons & 31;
    if (held !== pointer.held) pointer.hold(held, ev);
    else if (ev.type === "pointermove") pointer.move(pointer.x, pointer.y, ev);
  };
  view.addEventListener("pointerdown", (ev) => {
    ev.preventDefault();
    isTouch = ev.pointerType === "touch";
    view.focus({preventScroll: true});
    if (!pointer.isLocked) view.setPointerCapture(ev.pointerId);
    follow(ev);
  });
  for (const type of ["pointermove", "pointerup", "pointercancel", "lostpointercapture"]) {
    view.addEventListener(type, follow);
  }
  for (const type of ["enter", "leave"]) {
    view.addEventListener(`pointer${type}`, (ev) => ev.pointerType !== "touch" && pointer.send(`pointer_${type}`, ev));
  }
  view.addEventListener("dblclick", (ev) => isTouch || pointer.send("double_click", ev, 1));
  view.addEventListener("contextmenu", (ev) => ev.preventDefault());
  view.addEventListener("wheel", (ev) => {
    ev.preventDefault();
    const scale = WHEEL_SCALE[ev.deltaMode];
    pointer.wheel(ev.deltaX * scale, ev.deltaY * scale, ev);
  }, {passive: false});
  return pointer;
}

// One finger is the left button, two are the middle one and a wheel, and a tap is a click. A finger that has not moved
// yet may still become any of these, so nothing is said of it until then.
function watchTouch(pointer) {
  const fingers = new Map();
  let gesture = null, lastTap = {time: -Infinity};

  const pair = () => {
    const [a, b] = [...fingers.values()];
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, distance: Math.max(1, Math.hypot(a.x - b.x, a.y - b.y))};
  };
  const place = (at) => { [pointer.x, pointer.y] = [at.x, at.y]; };
  const begin = (ev) => {
    if (fingers.size === 1) gesture = {kind: "press", x: ev.clientX, y: ev.clientY};
    if (fingers.size !== 2 || gesture.kind === "over") return;
    pointer.hold(0, ev);
    gesture = {kind: "pair", ...pair()};
    place(gesture);
    pointer.hold(MIDDLE, ev);
  };
  const go = (ev) => {
    if (gesture.kind === "press" && Math.hypot(ev.clientX - gesture.x, ev.clientY - gesture.y) > TAP_DISTANCE) {
      place(gesture);
      pointer.hold(LEFT, ev);
      gesture = {kind: "drag"};
    }
    if (gesture.kind === "drag") pointer.move(ev.clientX, ev.clientY, ev);
    if (gesture.kind !== "pair") return;
    const next = {kind: "pair", ...pair()};
    pointer.move(next.x, next.y, ev);
    const doublings = Math.log2(next.distance / gesture.distance);
    if (doublings) pointer.wheel(0, -WHEEL_PER_DOUBLING * doublings, ev);
    gesture = next;
  };
  const tap = (ev) => {
    place(gesture);
    pointer.hold(LEFT, ev);
    pointer.hold(0, ev);
    const near = Math.hypot(gesture.x - lastTap.x, gesture.y - lastTap.y) < DOUBLE_TAP_DISTANCE;
    const isDouble = near && ev.timeStamp - lastTap.time < DOUBLE_TAP_TIME;
    if (isDouble) pointer.send("double_click", ev, 1);
    lastTap = isDouble ? {time: -Infinity} : {time: ev.timeStamp, x: gesture.x, y: gesture.y};
  };
  const end = (ev) => {
    if (gesture.kind === "press" && ev.type === "pointerup") tap(ev);
    pointer.hold(0, ev);
    gesture = {kind: "over"}; // a finger that is left means nothing more
  };
  return (ev) => {
    if (ev.type !== "pointerdown" && !fingers.has(ev.pointerId)) return;
    fingers.set(ev.pointerId, {x: ev.clientX, y: ev.clientY});
    if (ev.type === "pointerdown") begin(ev);
    else if (ev.type === "pointermove") go(ev);
    else {
      end(ev);
      fingers.delete(ev.pointerId);
    }
  };
}

// Browsers grant both only while a click or key is fresh: what is wanted is attempted now, and with each of them.
const mayAsk = () => navigator.userActivation?.isActive ?? true;

function watchPointerLock(view, pointer, send, keys) {
  let isWanted = false;
  const attempt = async () => {
    if (!isWanted || pointer.isLocked || !mayAsk()) return;
    try { await view.requestPointerLock(); } catch { /* refused: the next gesture */ }
  };
  document.addEventListener("pointerlockchange", () => {
    pointer.isLocked = document.pointerLockElement === view;
    if (pointer.isLocked && !isWanted) document.exitPointerLock();
    if (pointer.isLocked || !isWanted) return;
    isWanted = false; // the user wants out; the browser has kept the key to itself
    if (keys.isDown("Escape")) return;
    for (const type of ["key_down", "key_up"]) send({type, key: "Escape", modifiers: [], timestamp: timestamp()});
  });
  const set = (wanted) => {
    isWanted = wanted;
    if (wanted) attempt();
    else if (pointer.isLocked) document.exitPointerLock();
  };
  return {set, attempt};
}

function watchFullscreen(send) {
  let isWanted = false;
  const attempt = async () => {
    if (!isWanted || document.fullscreenElement || !mayAsk()) return;
    try { await document.documentElement.requestFullscreen(); } catch { /* refused: the next gesture */ }
  };
  document.addEventListener("fullscreenchange", () => {
    isWanted = Boolean(document.fullscreenElement);
    send({type: "fullscreen", value: isWanted});
  });
  const set = (wanted) => {
    isWanted = wanted;
    if (wanted) attempt();
    else if (document.fullscreenElement) document.exitFullscreen();
  };
  return {set, attempt};
}
