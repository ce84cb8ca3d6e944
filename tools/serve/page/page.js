// Shows the events of odom serve: the pose at 20 Hz, everything else twice a second.
"use strict";

const SECONDS = 60, CAMERAS = 100, DEGREES = 180 / Math.PI;
const $ = (selector) => document.querySelector(selector);
let car = null, beat = null, drawing = false, seen = 0;
let rows = [], cameras = [];  // a row: time, section of the trail, x, y, yaw, vx, vy, yaw rate

const fixed = (value, decimals) => (Number(value.toFixed(decimals)) || 0).toFixed(decimals);  // no "-0.0"
const isJoined = (r, next) => next[1] === r[1] && next[0] - r[0] < 1;
const slip = (r) => Math.abs(r[5]) > 0.3 ? Math.atan2(r[6], Math.abs(r[5])) * DEGREES : NaN;
const heading = (r) => Math.atan2(Math.sin(r[4]), Math.cos(r[4])) * DEGREES;
const strips = [  // name, unit, value, decimals, smallest range
  ["speed", "m/s", (r) => r[5], 2, 0.5], ["yaw rate", "°/s", (r) => r[7] * DEGREES, 1, 10],
  ["side slip", "°", slip, 1, 4], ["heading", "°", heading, 1, 10],
  ["x", "m", (r) => r[2], 2, 0.5], ["y", "m", (r) => r[3], 2, 0.5],
].map(([name, unit, value, decimals, range]) => {
  const cell = $("#strips div").appendChild(document.createElement("article"));
  cell.innerHTML = `<h3>${name} <b></b></h3><canvas></canvas>`;
  return {unit, value, decimals, range, text: cell.querySelector("b"), canvas: cell.querySelector("canvas")};
});

// A canvas ready to be drawn on, in CSS pixels.
function open(canvas) {
  const width = canvas.clientWidth, height = canvas.clientHeight, scale = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * scale);  // this clears the canvas
  canvas.height = Math.round(height * scale);
  const g = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
  g.scale(scale, scale);
  g.font = "12px system-ui, sans-serif";
  return {g, width, height, colour: (name) => style.getPropertyValue("--" + name)};
}

function line(g, points, colour, thickness) {
  g.beginPath();
  for (const [x, y, joined] of points) joined ? g.lineTo(x, y) : g.moveTo(x, y);
  g.strokeStyle = colour;
  g.lineWidth = thickness;
  g.stroke();
}

function text(g, words, x, y, colour) {
  g.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--card");
  g.lineWidth = 4;
  g.strokeText(words, x, y);
  g.fillStyle = colour;
  g.fillText(words, x, y);
}

function drawMap() {
  const {g, width, height, colour} = open($("#map canvas")), trail = car ? [...rows, car.row] : rows;
  if (trail.length === 0) return text(g, "no pose yet", 10, 20, colour("dim"));
  const xs = trail.map((r) => r[2]), ys = trail.map((r) => r[3]);
  const x0 = Math.min(...xs), x1 = Math.max(...xs), y0 = Math.min(...ys), y1 = Math.max(...ys);
  const scale = Math.min(width / Math.max(x1 - x0, 2), height / Math.max(y1 - y0, 2)) * 0.88;
  const at = (x, y) => [width / 2 + (x - (x0 + x1) / 2) * scale, height / 2 - (y - (y0 + y1) / 2) * scale];
  const power = 10 ** Math.floor(Math.log10(70 / scale));
  const step = power * [1, 2, 5, 10].find((n) => n * power * scale >= 69.9);
  const [ox, oy] = at(0, 0), pixels = step * scale;
  for (let x = (ox % pixels + pixels) % pixels; x < width; x += pixels)
    line(g, [[x, 0], [x, height, 1]], colour("line"), 1);
  for (let y = (oy % pixels + pixels) % pixels; y < height; y += pixels)
    line(g, [[0, y], [width, y, 1]], colour("line"), 1);
  line(g, [[10, height - 10], [10 + pixels, height - 10, 1]], colour("text"), 2);
  text(g, step >= 1 ? step + " m" : Math.round(step * 100) + " cm", 12, height - 16, colour("text"));
  line(g, trail.map((r, i) => [...at(r[2], r[3]), i > 0 && isJoined(trail[i - 1], r)]), colour("text"), 2);
  for (const [x, y] of cameras.map((c) => at(...c)))
    line(g, [[x - 4, y], [x + 4, y, 1], [x, y - 4], [x, y + 4, 1]], colour("warning"), 1.5);
  if (!car) return;
  const [long, short, direction] = car.ellipse;
  g.translate(...at(car.row[2], car.row[3]));
  g.fillStyle = colour("accent");
  g.globalAlpha = 0.25;
  g.beginPath();
  g.ellipse(0, 0, long * scale, short * scale, -direction, 0, 7);
  g.fill();
  g.globalAlpha = 1;
  g.rotate(-car.row[4]);
  g.fill(new Path2D("M13 0 L-9 8 L-5 0 L-9 -8 Z"));
}

function drawStrip(strip, end) {
  const {g, width, height, colour} = open(strip.canvas);
  const points = rows.map((r) => [r[0], strip.value(r)]), values = points.map((p) => p[1]).filter(isFinite);
  const last = car ? strip.value(car.row) : NaN;
  strip.text.textContent = (isFinite(last) ? fixed(last, strip.decimals) : "–") + " " + strip.unit;
  if (values.length === 0) return;
  const low = Math.min(...values), high = Math.max(...values), more = Math.max(strip.range - high + low, 0) / 2;
  const y = (value) => 4 + (height - 8) * (high + more - value) / (high - low + 2 * more);
  if (low - more < 0 && high + more > 0) line(g, [[0, y(0)], [width, y(0), 1]], colour("line"), 1);
  line(g, points.map(([t, value], i) => {
    const [t0, value0] = points[i - 1] || [];
    return [width * (1 - (end - t) / SECONDS), y(value), t - t0 < 1 && Math.abs(value - value0) < 180];
  }), colour("accent"), 1.5);
  text(g, fixed(high + more, 1), 2, 12, colour("dim"));
  text(g, fixed(low - more, 1), 2, height - 4, colour("dim"));
}

// Bucket i holds times up to 2^(i/4) µs.
function drawHistogram(canvas, counts) {
  const {g, width, height, colour} = open(canvas), wide = width / counts.length, floor = height - 16;
  g.fillStyle = colour("accent");
  counts.forEach((n, i) => {
    const high = n && Math.max(2, floor * Math.log1p(n) / Math.log1p(Math.max(...counts)));
    g.fillRect(i * wide, floor - high, Math.max(wide - 1, 1), high);
  });
  line(g, [[0, floor], [width, floor, 1]], colour("line"), 1);
  ["1 µs", "10", "100", "1 ms", "10"].forEach((words, i) =>
    text(g, words, 4 * Math.log2(10 ** i) * wide, height - 3, colour("dim")));
}

function draw() {
  drawing = false;
  drawMap();
  for (const strip of strips) drawStrip(strip, car ? car.t : rows.length ? rows.at(-1)[0] : 0);
  const [late, works] = document.querySelectorAll("#beat canvas");
  if (beat) drawHistogram(late, beat.late), drawHistogram(works, beat.works);
}

function onPose(pose) {
  document.body.classList.toggle("stale", !pose.live);
  car = pose.row ? pose : null;
  if (pose.n > seen + 10 && seen > 0) load();  // events were skipped
  seen = pose.n;
  if (pose.live && pose.n % 2 === 0) rows.push(pose.row);
  rows = rows.filter((r) => Math.abs(pose.t - r[0]) < SECONDS);
  $("#position").textContent = car ? `x ${fixed(car.row[2], 2)} m, y ${fixed(car.row[3], 2)} m ± ` +
    `${(car.ellipse[0] * 100).toFixed(1)} cm` : "";
  if (!drawing) requestAnimationFrame(draw);
  drawing = true;
}

function element(name, children, style = "") {
  const made = Object.assign(document.createElement(name), {className: style});
  made.append(...[children].flat());
  return made;
}

function onState(state) {
  $("#head").replaceChildren(...state.head.map((spans) =>
    element("p", spans.map(([words, style]) => element("span", words, style)))));
  complain(state.problem);
  if (state.camera) cameras = [...cameras, state.camera].slice(-CAMERAS);
  beat = state.beat || beat;
  $("#beat small").textContent = beat ? beat.text : "";
  $("#sources tbody").replaceChildren(...(state.sources || []).map(([name, is, fine, ...others]) =>
    element("tr", [element("td", name.replaceAll("_", " ")), element("td", is, fine ? "good" : "bad"),
      ...others.map((words) => element("td", words))])));
  $("#findings").hidden = !state.findings;
  $("#findings dl").replaceChildren(...(state.findings || []).flatMap(([what, fix]) =>
    [element("dt", what), element("dd", fix)]));
}

function complain(problem) {
  $("#problem").hidden = !problem;
  $("#problem").textContent = problem;
}

// The browser does not reopen a stream that was refused.
async function retry() {
  setTimeout(connect, 3000);
  const answer = await fetch("events", {method: "HEAD"}).catch(() => null);
  if (answer) complain(answer.status === 401 ? "No token: open this page once with /?token=TOKEN." :
    "The maximum number of viewers is reached. Trying again.");
}

async function load() {
  const answer = await fetch("history").catch(() => null);
  const past = answer && answer.ok ? await answer.json() : [];
  rows = [...past, ...rows.filter((r) => past.length === 0 || r[0] > past.at(-1)[0])];
}

function connect() {
  const events = new EventSource("events");
  events.onmessage = (event) => onPose(JSON.parse(event.data));
  events.addEventListener("state", (event) => onState(JSON.parse(event.data)));
  events.onopen = load;
  events.onerror = () => {
    document.body.classList.add("stale");
    complain("No connection to odom serve. Trying again.");
    if (events.readyState === EventSource.CLOSED) retry();
  };
}

connect();
