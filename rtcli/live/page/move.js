// The camera, moved by mouse and keys: a view only, until its lines are put into the file.

import * as camera from "/camera.js";
import { byId, copy, emit, fullSize, live, loadPass, on, report, say } from "/live.js";
import { post } from "/server.js";
import { stage } from "/view.js";

export const isCameraMode = () => document.querySelector("[name=mode]:checked").value === "camera";

let pivot = null; // the depth of the point that the camera turns about: what is in the middle of the picture

async function findPivot() {
  if (live.pose || !live.picture) return;
  const { values, width, height } = await loadPass("depth");
  const depth = values[Math.floor(height / 2) * width + Math.floor(width / 2)];
  const seen = Number.isFinite(depth) ? depth : values.find(Number.isFinite);
  pivot = seen > 0 ? seen : null;
}

function current() {
  if (live.pose) return live.pose;
  const { position, look_at, up, matrix } = live.state.camera;
  const pose = { position, look_at, up: matrix ? camera.rounded(up) : up };
  return pivot ? camera.aim(pose, pivot) : pose;
}

function set(pose) {
  live.pose = pose;
  emit("view");
}

// --- Keys and buttons ------------------------------------------------------------------------------------

// One step: 5 degrees, 3 % of the distance, a tenth closer.
const STEPS = {
  orbit: (pose, x, y) => camera.orbit(pose, x * 0.087, y * 0.087),
  pan: (pose, x, y) => camera.pan(pose, x * 0.03, y * 0.03),
  dolly: (pose, x, y) => camera.dolly(pose, 1.1 ** y),
};

export async function step(name, x, y) {
  if (!live.state?.camera) return;
  if (!live.pose && !pivot) await findPivot().catch(report);
  set(STEPS[name](current(), x, y));
}

for (const button of document.querySelectorAll("[data-move]")) {
  const { move, x, y } = button.dataset;
  button.addEventListener("click", () => step(move, Number(x), Number(y)));
}

// --- Pointer ---------------------------------------------------------------------------------------------

const MIDDLE = 4; // of the buttons of a mouse

export function drag(dx, dy, event) {
  if (!isCameraMode() || !live.state?.camera) return false;
  live.isMoving = true;
  const height = stage.height * stage.scale;
  const [x, y] = [dx / height, dy / height];
  const share = 2 * Math.tan(((live.state.camera.fov ?? 40) * Math.PI) / 360); // of the distance, in the whole height
  if (event.shiftKey || event.buttons === MIDDLE) set(camera.pan(current(), x * share, y * share));
  else if (event.altKey) set(camera.dolly(current(), 4 ** y));
  else set(camera.orbit(current(), x * Math.PI, y * Math.PI));
  return true;
}

export function wheel(event) {
  if (!isCameraMode() || event.ctrlKey || !live.state?.camera) return false;
  set(camera.dolly(current(), 2 ** ((event.deltaMode ? event.deltaY * 30 : event.deltaY) / 480)));
  return true;
}

export function drop() {
  if (!live.isMoving) return;
  live.isMoving = false;
  live.share = 1;
  emit("view");
}

const SMOOTH = 80; // milliseconds for a picture while the camera moves

// A slow scene moves in a smaller size, and gets its pixels back when the pointer is released.
export function adaptSize(milliseconds) {
  if (!live.isMoving) return;
  const share = Math.max(0.1, (live.picture.width / fullSize().width) * Math.sqrt(SMOOTH / milliseconds));
  live.share = share > 0.8 ? 1 : share;
}

// --- The panel -------------------------------------------------------------------------------------------

function show() {
  const { projection, fov, lines, writable, matrix } = live.state.camera ?? {};
  if (!projection) return;
  byId("camera-lines").textContent = camera.yaml(live.pose ?? live.state.camera);
  byId("camera-reset").disabled = !live.pose;
  byId("camera-write").hidden = !live.state.write;
  byId("camera-write").disabled = !live.pose || !writable;
  const angle = fov ? `, ${Number(fov.toPrecision(4))}° high` : "";
  const where = lines ? `, lines ${lines[0]} to ${lines[1]}` : "";
  const onlyCopied = " They cannot be written, since the file does not give position and look_at as numbers.";
  byId("camera-what").textContent = live.pose
    ? `View only: the file has another camera. Put these lines into it${matrix ? `, instead of ${matrix},` : ""} to keep the view.${live.state.write && !writable ? onlyCopied : ""}`
    : `As in the file${where}: ${projection}${angle}.`;
}

let written = null; // a pose that the file will have with one of the next states: until then it stays

on("state", () => {
  const isSame = (key) => live.state.camera[key].every((each, axis) => each === written[key][axis]);
  if (written && live.state.camera && ["position", "look_at", "up"].every(isSame)) {
    if (live.pose === written) live.pose = null;
    written = null;
    emit("view");
  }
  show();
});
on("view", show);
on("picture", () => {
  if (live.pose) return;
  pivot = null;
  if (isCameraMode()) findPivot().catch(report);
});
byId("camera-reset").addEventListener("click", () => set(null));
byId("camera-copy").addEventListener("click", () => copy(byId("camera-lines").textContent, "The lines are copied"));
byId("camera-write").addEventListener("click", async () => {
  try {
    await post("/camera", { ...live.pose, version: live.state.picture.version });
    say("The camera is written into the file");
    written = live.pose;
  } catch (error) {
    report(error);
  }
});

// --- The mode --------------------------------------------------------------------------------------------

const modes = document.querySelectorAll("[name=mode]");

function modeChanged() {
  byId("stage").classList.toggle("camera", isCameraMode());
  byId("stage").ariaLabel = isCameraMode() ? "Picture: arrow keys orbit the camera" : "Picture: arrow keys move the pixel";
  if (isCameraMode()) findPivot().catch(report);
  emit("mode", isCameraMode());
}

export function toggleMode() {
  [...modes].find((mode) => !mode.checked).checked = true;
  modeChanged();
}

modes.forEach((radio) => radio.addEventListener("change", modeChanged));
