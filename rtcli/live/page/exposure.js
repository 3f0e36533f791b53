// Exposure, and the histogram of the picture with what is clipped.

import { BLACK, WHITE, canvasOf, histogram } from "/image.js";
import { byId, counted, emit, live, on, say } from "/live.js";
import { stage } from "/view.js";

// --- Exposure --------------------------------------------------------------------------------------------

const inputs = [byId("exposure"), byId("exposure-number")];
const ofFile = () => live.state.picture?.exposure ?? 0;
const rounded = (value) => Number(value.toFixed(3));

function set(value) {
  live.exposure = value;
  emit("view");
}

export function stepExposure(stops) {
  set(rounded((live.exposure ?? ofFile()) + stops));
}

function show() {
  const value = rounded(live.exposure ?? ofFile());
  for (const input of inputs) if (input.valueAsNumber !== value) input.value = value;
  byId("exposure-reset").disabled = live.exposure === null;
  const tone = `tone curve ${live.state.picture?.tone ?? "clip"}.`;
  byId("exposure-what").textContent = live.exposure === null ? `As in the file; ${tone}`
    : `View only: the file has ${rounded(ofFile())} EV; ${tone}`;
}

for (const input of inputs) {
  input.addEventListener("input", () => {
    if (Number.isFinite(input.valueAsNumber)) set(input.valueAsNumber);
  });
}
byId("exposure-reset").addEventListener("click", () => set(null));
on("state", show);
on("view", show);

// --- Histogram -------------------------------------------------------------------------------------------

// A line for each channel, told apart by its dashes too; the height is the square root of the count.
const LINES = [[".red", []], [".green", [6, 3]], [".blue", [2, 2]]];

let counts = null;

export function showHistogram() {
  const isShown = !byId("panel-exposure").hidden;
  if (!live.picture || live.isMoving || !(isShown || isClippedShown())) return;
  counts ??= histogram(live.picture);
  if (isShown) {
    drawLines(byId("histogram"), counts);
    byId("histogram-text").textContent = clippedText(counts);
  }
  stage.draw();
}

function drawLines(canvas, { bins }) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  // The ends, which hold what is clipped, do not decide the height.
  const most = Math.max(...bins.flatMap((each) => [...each.subarray(1, 255)]), 1);
  const y = (count) => height - 2 - (height - 6) * Math.min(Math.sqrt(count / most), 1);
  LINES.forEach(([name, dashes], channel) => {
    context.strokeStyle = getComputedStyle(document.querySelector(`.key ${name}`)).stroke;
    context.lineWidth = 1.5;
    context.setLineDash(dashes);
    context.beginPath();
    bins[channel].forEach((count, level) => context.lineTo(1 + ((width - 2) * level) / 255, y(count)));
    context.stroke();
  });
}

function clippedText({ clipped, width, height }) {
  const part = (count) => {
    const percent = (100 * count) / (width * height);
    const text = percent && percent < 0.01 ? "less than 0.01" : Number(percent.toPrecision(2));
    return `${counted(count, "pixel")} (${text} %)`;
  };
  return `Clipped: ${part(clipped[WHITE])} with a channel at 255, ${part(clipped[BLACK])} black.`;
}

on("picture", () => {
  counts = null;
  showHistogram();
});
new ResizeObserver(showHistogram).observe(byId("histogram"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", showHistogram);

// --- Clipped pixels in the picture -----------------------------------------------------------------------

const isClippedShown = () => byId("clipped").ariaPressed === "true";

export function toggleClipped() {
  byId("clipped").ariaPressed = String(!isClippedShown());
  showHistogram();
  stage.draw();
  if (isClippedShown() && counts && byId("panel-exposure").hidden) say(clippedText(counts));
}

byId("clipped").addEventListener("click", toggleClipped);

const SIDE = 8;

// Stripes that rise to the right for pixels that are too bright, and to the left for black ones.
function stripes(line) {
  const pixels = new Uint8ClampedArray(4 * SIDE ** 2);
  for (let at = 0; at < SIDE ** 2; at++) {
    const isDark = (line(at % SIDE, Math.floor(at / SIDE)) & (SIDE - 1)) < SIDE / 2;
    pixels.set(isDark ? [0, 0, 0, 255] : [255, 255, 255, 255], 4 * at);
  }
  return canvasOf(pixels, SIDE, SIDE);
}

const STRIPES = { [WHITE]: stripes((x, y) => x + y), [BLACK]: stripes((x, y) => x - y) };

stage.overlays.push((context, port) => {
  if (!isClippedShown() || !counts || port.image !== live.picture.bitmap) return;
  const { masks, width, height } = counts;
  for (const [kind, pattern] of Object.entries(STRIPES)) {
    counts.canvases ??= {};
    counts.canvases[kind] ??= canvasOf(masks[kind], width, height);
    const layer = new OffscreenCanvas(stage.canvas.width, stage.canvas.height);
    const over = layer.getContext("2d");
    over.imageSmoothingEnabled = false;
    over.scale(stage.ratio, stage.ratio);
    over.drawImage(counts.canvases[kind], port.left, port.top, stage.width * stage.scale, stage.height * stage.scale);
    over.globalCompositeOperation = "source-in";
    over.fillStyle = over.createPattern(pattern, "repeat");
    over.fillRect(0, 0, stage.element.clientWidth, stage.element.clientHeight);
    context.drawImage(layer, 0, 0, stage.element.clientWidth, stage.element.clientHeight);
  }
});
