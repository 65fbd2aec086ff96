// The page of glimt's viewer: shows the frames that the server sends, and tells it what is done here.
// The messages are those of rendercanvas' remote canvases.

const query = location.search; // the token, which everything that is asked for needs
const {watchInput} = await import(`./input.js${query}`);

const MAX_RATIO = 2; // physical pixels a logical one: more would cost more than anybody sees
const MAX_SILENCE = 10_000; // ms; the server says something every four seconds
const MIN_DELAY = 250, MAX_DELAY = 5000; // ms between attempts to connect
const RESIZE_INTERVAL = 100; // ms
const HINT_TIME = 8000; // ms

const [view, status, hint, help, helpColumns, helpButton] =
  ["view", "status", "hint", "help", "help-columns", "help-button"].map((id) => document.getElementById(id));

let socket = null; // the connection, be it still being made
let isActive = false; // whether this page steers, or watches
let heard = 0, delay = MIN_DELAY, retry = 0;

const send = (message) => socket?.readyState === WebSocket.OPEN && socket.send(JSON.stringify(message));
const input = watchInput(view, (event) => isActive && send(event));

// ---- connection

function connect() {
  const url = new URL(`ws${query}`, location);
  url.protocol = location.protocol.replace("http", "ws");
  const ws = socket = new WebSocket(url);
  heard = performance.now();
  ws.binaryType = "arraybuffer";
  let header = null; // of the bytes that come next
  ws.onopen = () => {
    delay = MIN_DELAY;
    sendSize();
  };
  ws.onmessage = ({data}) => {
    heard = performance.now();
    if (typeof data === "string") {
      const message = JSON.parse(data);
      header = message.nbuffers ? message : null;
      if (!header) HANDLERS[message.type]?.(message.value);
    } else if (header?.type === "framebufferdata") showFrame(ws, header, data);
    else if (header?.type === "file") saveFile(header, data);
  };
  ws.onclose = () => lose(ws);
}

function lose(ws) {
  ws.onopen = ws.onmessage = ws.onclose = null;
  ws.close();
  input.release();
  input.setPointerLock(false);
  socket = null;
  isActive = false;
  showStatus("reconnecting");
  retry = setTimeout(connect, delay * (0.75 + Math.random() / 2));
  delay = Math.min(2 * delay, MAX_DELAY);
}

function hurry() {
  if (socket || document.hidden) return;
  clearTimeout(retry);
  connect();
}

setInterval(() => socket && performance.now() - heard > MAX_SILENCE && lose(socket), 1000);
window.addEventListener("online", hurry);
document.addEventListener("visibilitychange", hurry);

const HANDLERS = {
  title: (value) => { document.title = value; },
  cursor: (value) => { view.style.cursor = value; },
  active: (value) => {
    isActive = value;
    showStatus(value ? "connected" : "watching");
  },
  pointer_lock: input.setPointerLock,
  fullscreen: input.setFullscreen,
};

function showStatus(state) {
  status.textContent = status.dataset.state = state;
}

// ---- frames

const canvas = view.getContext("bitmaprenderer");
let decoded = null; // the newest frame that is not on the screen yet

async function showFrame(ws, header, data) {
  let bitmap;
  try {
    bitmap = await createImageBitmap(new Blob([data], {type: header.mimetype}));
  } catch {
    bitmap = null; // damaged: the server goes on with the next one
  }
  if (ws !== socket || decoded?.index > header.index) return bitmap?.close();
  if (!decoded) requestAnimationFrame(paint);
  decoded?.bitmap?.close();
  decoded = {bitmap, index: header.index, timestamp: header.timestamp};
}

// The feedback lets the server send another frame: a page that is hidden paints none and gets none.
function paint() {
  const {bitmap, index, timestamp} = decoded;
  decoded = null;
  if (bitmap) {
    if (view.width !== bitmap.width) view.width = bitmap.width; // its own size, from which its shape follows
    if (view.height !== bitmap.height) view.height = bitmap.height;
    const stretch = (bitmap.width * view.clientHeight) / (bitmap.height * view.clientWidth);
    view.style.objectFit = Math.abs(stretch - 1) < 0.02 ? "fill" : "contain";
    canvas.transferFromImageBitmap(bitmap);
  }
  send({type: "_framefeedback", index, timestamp, localtime: Date.now() / 1000});
}

let resizing = 0;

function sendSize() {
  resizing = 0;
  const ratio = Math.min(window.devicePixelRatio, MAX_RATIO);
  const [width, height] = [view.clientWidth, view.clientHeight];
  send({type: "resize", width, height, pwidth: Math.round(width * ratio), pheight: Math.round(height * ratio), ratio,
    timestamp: performance.now() / 1000});
}

window.addEventListener("resize", () => { resizing ||= setTimeout(sendSize, RESIZE_INTERVAL); });

// ---- files and help

function saveFile({name, mimetype}, data) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([data], {type: mimetype}));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

function element(tag, text) {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}

async function fillHelp() {
  const keys = await (await fetch(`keys.json${query}`)).json();
  for (const name of new Set(keys.map((key) => key.group))) {
    const group = document.createElement("div");
    const list = document.createElement("dl");
    for (const key of keys.filter((other) => other.group === name)) {
      list.append(element("dt", [key.keys].flat().join(" ")), element("dd", key.help));
    }
    group.append(element("h2", name), list);
    helpColumns.append(group);
  }
}

async function showHelp(isShown) {
  if (isShown && !helpColumns.childElementCount) await fillHelp();
  help.hidden = !isShown;
  helpButton.setAttribute("aria-expanded", isShown);
}

helpButton.addEventListener("click", () => {
  showHelp(help.hidden);
  view.focus();
});
view.addEventListener("pointerdown", () => showHelp(false));

const hideHint = () => hint.classList.add("past");
setTimeout(hideHint, HINT_TIME);
window.addEventListener("keydown", hideHint, {once: true});
view.focus();
connect();
