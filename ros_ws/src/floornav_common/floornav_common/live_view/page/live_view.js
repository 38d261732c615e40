"use strict";
// One websocket in, one canvas out. Everything drawn is in the map frame, metres, y up.

const $ = (id) => document.getElementById(id);
const LEVELS = ["OK", "WARN", "ERROR", "STALE"];
const LAYERS = {  // name: [title, color]; drawn in this order
  map: ["map", "#f7f9fb"], trajectory: ["way so far", "#8d7bd8"], sonar: ["sonars", "#d98a1f"],
  ways: ["ways weighed", "#9aa7b5"], zones: ["zones", "#a86b00"], glass: ["glass", "#00b4d8"],
  scan: ["scan", "#e5383b"], path: ["path", "#2f6fed"], people: ["people", "#d6249f"],
  robot: ["robot", "#2a3f9d"], goal: ["goal", "#1f9d55"],
};
const seen = {};         // newest content of each slot, with the time it came
const hidden = new Set();
const view = { x: 0, y: 0, scale: 60, isFit: true, isFollowing: false };
let info = { outline: [], silent_after_s: 2 }, socket = null, heardAt = 0, isDirty = true;
let aim = null, isAiming = false, answerTimer = 0;

const isFresh = (slot) => slot in seen && Date.now() - seen[slot].at < 1000 * info.silent_after_s;
const color = (layer) => LAYERS[layer][1];

// ---- the websocket -------------------------------------------------------------------------

function connect() {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    heardAt = Date.now();
    if (typeof data === "string") return take(JSON.parse(data), null);
    const length = new DataView(data).getUint32(0, true);
    const head = new TextDecoder().decode(new Uint8Array(data, 4, length));
    take(JSON.parse(head), data.slice(4 + length));
  };
  socket.onopen = () => { heardAt = Date.now(); banner(); };
  socket.onclose = () => { socket = null; banner(); setTimeout(connect, 1000); };
}

function take(message, payload) {
  const slot = message.kind;
  if (slot === "map" || slot === "glass") return takeGrid(slot, message, payload);
  if (payload && slot !== "image") message.points = new Float32Array(payload);
  seen[slot] = { ...message, at: Date.now() };
  const show = { info: showInfo, planner: showPlanner, diagnostics: showDiagnostics,
    health: showHealth, answer: showAnswer, image: () => showImage(payload) }[slot];
  if (show) show(message);
  isDirty = true;
}

async function takeGrid(slot, message, payload) {
  const number = (takeGrid.count = (takeGrid.count || 0) + 1);
  const options = { colorSpaceConversion: "none", premultiplyAlpha: "none" };
  const picture = await createImageBitmap(new Blob([payload], { type: "image/png" }), options);
  if (seen[slot] && seen[slot].number > number) return;  // a newer one was decoded sooner
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [message.width, message.height];
  const context = canvas.getContext("2d");
  context.drawImage(picture, 0, 0);
  const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
  const known = paint(pixels.data, canvas.width, slot === "glass");
  context.putImageData(pixels, 0, 0);
  seen[slot] = { ...message, canvas, known, number, at: Date.now() };
  if (slot === "map" && view.isFit) fit();
  isDirty = true;
}

// Colors the picture of a map (0 unknown, else 1 + occupancy); returns the columns and rows known.
function paint(data, width, isGlass) {
  let [left, right, top, bottom] = [Infinity, -1, Infinity, -1];
  for (let i = 0; i < data.length; i += 4) {
    const occupied = (data[i] - 1) / 100;
    if (isGlass) {
      data[i] = 0; data[i + 1] = 180; data[i + 2] = 216; data[i + 3] = occupied >= 0.65 ? 255 : 0;
    } else if (occupied < 0) {
      data[i + 3] = 0;
    } else {
      const mix = (free, wall) => free + (wall - free) * occupied;
      data[i] = mix(247, 28); data[i + 1] = mix(249, 36); data[i + 2] = mix(251, 48);
      const column = (i / 4) % width, row = (i / 4 - column) / width;
      left = Math.min(left, column); right = Math.max(right, column + 1);
      top = Math.min(top, row); bottom = Math.max(bottom, row + 1);
    }
  }
  return { left, right, top, bottom };
}

// ---- drawing -------------------------------------------------------------------------------

const floor = $("floor"), ctx = floor.getContext("2d");
const middle = () => [floor.clientWidth / 2, floor.clientHeight / 2];
function toScreen(x, y) {
  const [cx, cy] = middle();
  return [cx + (x - view.x) * view.scale, cy - (y - view.y) * view.scale];
}
function toMap(px, py) {
  const [cx, cy] = middle();
  return [view.x + (px - cx) / view.scale, view.y - (py - cy) / view.scale];
}

function fit() {  // what is known of the map, in the middle
  const { origin, height, resolution, known } = seen.map || {};
  if (!known || known.right < 0) return;
  const [c, s] = [Math.cos(origin.yaw), Math.sin(origin.yaw)];
  const [w, h] = [(known.right - known.left) * resolution, (known.bottom - known.top) * resolution];
  const u = known.left * resolution + w / 2, v = (height - known.bottom) * resolution + h / 2;
  view.x = origin.x + c * u - s * v;
  view.y = origin.y + s * u + c * v;
  const [cx, cy] = middle();
  const [boxW, boxH] = [Math.abs(c) * w + Math.abs(s) * h, Math.abs(s) * w + Math.abs(c) * h];
  view.scale = Math.min(400, Math.max(2, 0.9 * Math.min(2 * cx / boxW, 2 * cy / boxH)));
  isDirty = true;
}

function lines(points, isStrip, width, style) {
  ctx.beginPath();
  for (let i = 0; i < points.length; i += 2) {
    const isStart = isStrip ? i === 0 : i % 4 === 0;
    ctx[isStart ? "moveTo" : "lineTo"](points[i], points[i + 1]);
  }
  stroke(width, style);
}
function stroke(width, style) {
  ctx.lineWidth = width / view.scale;
  ctx.strokeStyle = style;
  ctx.stroke();
}
function dots(points, size, style) {
  const d = size / view.scale;
  ctx.fillStyle = style;
  for (let i = 0; i < points.length; i += 2) ctx.fillRect(points[i] - d / 2, points[i + 1] - d / 2, d, d);
}
function inRobot(drawIt) {
  const pose = seen.pose && seen.pose.pose;
  if (!pose) return;
  ctx.save();
  ctx.translate(pose.x, pose.y);
  ctx.rotate(pose.yaw);
  drawIt();
  ctx.restore();
}
function grid(slot) {
  const { origin, canvas, resolution, width, height } = seen[slot];
  ctx.save();
  ctx.translate(origin.x, origin.y);
  ctx.rotate(origin.yaw);
  ctx.scale(resolution, -resolution);
  ctx.imageSmoothingEnabled = false;
  ctx.drawImage(canvas, 0, -height, width, height);
  ctx.restore();
}
function markers(names) {
  let at = 0;
  for (const { name, points, color: style, num } of seen.markers.groups) {
    const part = seen.markers.points.subarray(at / 4, (at + num) / 4);
    at += num;
    if (!names(name)) continue;
    if (points) dots(part, 3, style);
    else lines(part, false, 2, name === "people" ? color("people") : name === "zones" ? color("zones") : style);
  }
}
function arrow(x, y, yaw, style) {
  const d = 12 / view.scale;
  ctx.beginPath();
  ctx.arc(x, y, d, 0, 7);
  stroke(3, style);
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x + 2.4 * d * Math.cos(yaw), y + 2.4 * d * Math.sin(yaw));
  stroke(3, style);
}

const DRAW = {
  map: () => seen.map && grid("map"),
  glass: () => seen.glass && grid("glass"),
  trajectory: () => seen.trajectory && lines(seen.trajectory.points, true, 2, color("trajectory")),
  sonar: () => isFresh("sonar") && inRobot(() => {
    for (const { x, y, yaw, opening, reach, echo } of seen.sonar.cones) {
      ctx.beginPath();
      ctx.moveTo(x, y);
      ctx.arc(x, y, reach, yaw - opening / 2, yaw + opening / 2);
      ctx.closePath();
      ctx.fillStyle = echo ? "rgba(232,163,61,.16)" : "rgba(232,163,61,.04)";
      ctx.fill();
      if (!echo) continue;
      ctx.beginPath();
      ctx.arc(x, y, reach, yaw - opening / 2, yaw + opening / 2);
      stroke(2, color("sonar"));
    }
  }),
  ways: () => isFresh("markers") && markers((name) => name !== "zones" && name !== "people"),
  zones: () => isFresh("markers") && markers((name) => name === "zones"),
  people: () => isFresh("markers") && markers((name) => name === "people"),
  scan: () => isFresh("scan") && dots(seen.scan.points, 3, color("scan")),
  path: () => seen.path && lines(seen.path.points, true, 3, color("path")),
  robot: () => inRobot(() => {
    ctx.beginPath();
    for (const [x, y] of info.outline) ctx.lineTo(x, y);
    ctx.closePath();
    ctx.fillStyle = "rgba(60,92,220,.55)";
    ctx.fill();
    stroke(2, color("robot"));
    ctx.beginPath();
    ctx.moveTo(0, 0);
    ctx.lineTo(Math.max(0.25, 16 / view.scale), 0);
    stroke(3, color("robot"));
  }),
  goal: () => seen.goal && arrow(seen.goal.x, seen.goal.y, seen.goal.yaw, color("goal")),
};

function draw() {
  requestAnimationFrame(draw);
  if (!isDirty) return;
  isDirty = false;
  const ratio = window.devicePixelRatio || 1, [cx, cy] = middle();
  const size = [Math.round(2 * cx * ratio), Math.round(2 * cy * ratio)];
  if (floor.width !== size[0] || floor.height !== size[1]) [floor.width, floor.height] = size;
  const pose = seen.pose && seen.pose.pose;
  if (view.isFollowing && pose) [view.x, view.y] = [pose.x, pose.y];
  ctx.setTransform(1, 0, 0, 1, 0, 0);
  ctx.clearRect(0, 0, floor.width, floor.height);
  const k = view.scale * ratio;
  ctx.setTransform(k, 0, 0, -k, cx * ratio - view.x * k, cy * ratio + view.y * k);
  ctx.lineJoin = ctx.lineCap = "round";
  for (const layer of Object.keys(LAYERS)) if (!hidden.has(layer)) DRAW[layer]();
  if (aim) arrow(aim.x, aim.y, aim.yaw, "#0b6b34");
  const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((m) => m * view.scale > 60) || 100;
  const bar = $("scale").firstElementChild;
  bar.textContent = `${step} m`;
  bar.style.width = `${step * view.scale}px`;
}

// ---- the side ------------------------------------------------------------------------------

const text = (node, words) => { if (node.textContent !== words) node.textContent = words; };
const LISTS = { trouble: $("troubles"), part: $("parts"), input: $("inputs") };
function fill(list, rows) {  // rows: [level, name, words]
  list.replaceChildren(...rows.map(([level, name, words]) => {
    const item = document.createElement("li");
    item.dataset.level = level;
    item.append(Object.assign(document.createElement("b"), { textContent: name }),
      Object.assign(document.createElement("span"), { textContent: words }));
    return item;
  }));
}
function showInfo(message) {
  info = message;
  text($("robot"), info.robot === "/" ? "" : info.robot);
  text($("camera-topic"), info.image_topic);
  document.title = `floornav ${info.robot}`;
}
function showPlanner({ level, message, values }) {
  const state = values.state || message, box = $("planner");
  box.dataset.level = level;
  text(box.querySelector(".state"), state);
  text(box.querySelector(".reason"), values.reason || "");
  const left = values["distance left (m)"], waited = Number(values["waited (s)"] || 0);
  const figures = [left && `${left} m left`, waited > 0 && `waited ${waited} s`];
  text(box.querySelector(".figures"), figures.filter(Boolean).join(" · "));
}
function showImage(payload) {
  const picture = $("camera").querySelector("img");
  $("camera").hidden = false;
  if (picture.src) URL.revokeObjectURL(picture.src);
  picture.src = URL.createObjectURL(new Blob([payload], { type: "image/jpeg" }));
}
function showDiagnostics({ parts }) {
  const rank = [0, 2, 3, 1];  // errors first, then warnings, then silence
  const row = ({ level, name, message }) => [level, name, `${LEVELS[level]}: ${message}`];
  const bad = parts.filter((p) => p.level).sort((a, b) => rank[b.level] - rank[a.level]);
  text($("summary"), `${parts.length - bad.length} of ${parts.length} parts OK`);
  fill(LISTS.trouble, bad.map(row));
  if (LISTS.part.parentElement.open) fill(LISTS.part, parts.map(row));
}
function showHealth({ inputs, clock, simulated }) {
  text($("clock"), simulated ? `${clock.toFixed(1)} s simulated` : new Date(clock * 1000).toLocaleTimeString());
  const words = (age) => (age === null ? "not heard" : age < 1 ? "now" : `${age.toFixed(0)} s ago`);
  fill(LISTS.input, inputs.map(({ topic, age }) => [age === null ? 3 : 0, topic, words(age)]));
  banner();
}
function showAnswer({ ok, text: words }) {
  const box = $("answer");
  box.textContent = words;
  box.className = ok ? "" : "bad";
  box.hidden = false;
  clearTimeout(answerTimer);
  answerTimer = setTimeout(() => { box.hidden = true; }, 5000);
}
function banner() {
  const box = $("banner"), silent = (Date.now() - heardAt) / 1000;
  const isUp = socket && socket.readyState === WebSocket.OPEN;
  const isLost = !isUp || silent > 3;
  const problems = (seen.health && seen.health.problems) || [];
  let words = problems.join("\n");
  if (!isUp) words = "No connection to live_view: trying again. What is drawn is old.";
  else if (isLost) words = `live_view says nothing for ${silent.toFixed(0)} s. What is drawn is old.`;
  box.className = isLost ? "lost" : "";
  floor.style.opacity = isLost ? 0.45 : 1;
  text(box, words);
  box.hidden = !words;
}

// ---- hands ---------------------------------------------------------------------------------

function press(button, isOn) { $(button).setAttribute("aria-pressed", String(isOn)); isDirty = true; }
function setAiming(isOn) {
  isAiming = isOn;
  aim = null;
  press("goal", isOn);
  floor.classList.toggle("aiming", isOn);
}
function setFollowing(isOn) { view.isFollowing = isOn; if (isOn) view.isFit = false; press("follow", isOn); }
function sendGoal({ x, y, yaw }) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ kind: "goal", x, y, yaw }));
  else showAnswer({ ok: false, text: "no connection: the goal was not sent" });
}

let held = null;
floor.onpointerdown = (event) => {
  floor.setPointerCapture(event.pointerId);
  held = [event.offsetX, event.offsetY];
  if (!isAiming || event.button !== 0) return;
  const [x, y] = toMap(...held), pose = seen.pose && seen.pose.pose;
  // A click without a drag: on in the direction from here to there.
  aim = { x, y, yaw: pose ? Math.atan2(y - pose.y, x - pose.x) : 0 };
  isDirty = true;
};
floor.onpointermove = (event) => {
  if (!held) return;
  if (aim) {
    const [x, y] = toMap(event.offsetX, event.offsetY);
    if (Math.hypot(x - aim.x, y - aim.y) * view.scale > 10) aim.yaw = Math.atan2(y - aim.y, x - aim.x);
  } else {
    view.x -= (event.offsetX - held[0]) / view.scale;
    view.y += (event.offsetY - held[1]) / view.scale;
    held = [event.offsetX, event.offsetY];
    view.isFit = false;
    setFollowing(false);
  }
  isDirty = true;
};
floor.onpointerup = () => {
  held = null;
  if (!aim) return;
  sendGoal(aim);
  setAiming(false);
};
floor.onpointercancel = () => { held = aim = null; };
floor.oncontextmenu = (event) => event.preventDefault();
floor.addEventListener("wheel", (event) => {
  event.preventDefault();
  const [x, y] = toMap(event.offsetX, event.offsetY);
  view.scale = Math.min(2000, Math.max(1, view.scale * Math.exp(-event.deltaY * 0.0015)));
  const [nx, ny] = toMap(event.offsetX, event.offsetY);
  view.x += x - nx;
  view.y += y - ny;
  view.isFit = false;
  isDirty = true;
}, { passive: false });
$("goal").onclick = () => setAiming(!isAiming);
$("follow").onclick = () => setFollowing(!view.isFollowing);
$("fit").onclick = () => { setFollowing(false); view.isFit = true; fit(); };
window.onkeydown = ({ key }) => {
  const button = { g: "goal", r: "follow", f: "fit" }[key.toLowerCase()];
  if (button) $(button).click();
  if (key === "Escape") setAiming(false);
};
window.onresize = () => { if (view.isFit) fit(); isDirty = true; };

for (const [layer, [title, swatch]] of Object.entries(LAYERS)) {
  const label = document.createElement("label"), box = document.createElement("input");
  Object.assign(box, { type: "checkbox", checked: true });
  box.onchange = () => { hidden[box.checked ? "delete" : "add"](layer); isDirty = true; };
  const mark = document.createElement("i");
  mark.style.background = swatch;
  label.append(box, mark, title);
  $("layers").append(label);
}
setInterval(() => { banner(); isDirty = true; }, 500);  // what is silent fades out
connect();
draw();
