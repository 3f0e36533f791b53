// What the page knows, and how its parts tell each other of changes. Text from the scene goes into the page by
// textContent and the like only, never as HTML.

import * as camera from "/camera.js";
import { decodePass } from "/passes.js";
import { ServerError, get } from "/server.js";

export const live = {
  state: null, // of the server
  picture: null, // the newest, as the view shows it
  passes: new Map(), // promises of passes of that view, by name
  exposure: null, // null: of the file
  pose: null, // null: of the file
  share: 1, // of width and height, less while the camera moves
  isMoving: false, // the camera, by a pointer
  pixel: null,
  pin: null, // the pixel beside it
  lit: null, // the index of the highlighted object
  opened: null, // the index of the opened one
};

// Events: state (the one before), picture, shown, view (exposure or pose changed), light, open, pixel, mode, panel.
const listeners = new Map();

export function on(name, listener) {
  listeners.set(name, [...(listeners.get(name) ?? []), listener]);
}

export function emit(name, value) {
  for (const listener of listeners.get(name) ?? []) listener(value);
}

// --- Requests for the view -------------------------------------------------------------------------------

function poseQuery() {
  return live.pose ? camera.query(live.pose) : {};
}

// As large as the server traces for a view, or smaller while the camera moves.
function sizedQuery() {
  const { width, height } = fullSize();
  const most = live.state?.limits.pixels ?? Infinity;
  const share = Math.min(live.share, Math.sqrt(most / (width * height || 1)));
  if (!live.pose || share >= 1) return poseQuery();
  return { ...poseQuery(), size: [width, height].map((side) => Math.max(1, Math.floor(side * share))).join("x") };
}

const exposed = (query) => (live.exposure === null ? query : { ...query, exposure: live.exposure });

export const pictureQuery = () => exposed(sizedQuery());

export const pixelQuery = () => exposed(poseQuery());

export function loadPass(name) {
  const { passes } = live;
  if (!passes.has(name)) {
    passes.set(name, get("/pass", { name, ...sizedQuery() }).then(decodePass));
    passes.get(name).catch(() => passes.delete(name));
  }
  return passes.get(name);
}

// The size of the scene: a preview, and the picture of a camera that moves, are smaller.
export function fullSize() {
  return live.state?.picture ?? { width: 0, height: 0 };
}

// --- The page --------------------------------------------------------------------------------------------

export const byId = (id) => document.getElementById(id);

export const counted = (count, one, many = `${one}s`) => `${count.toLocaleString("en")} ${count === 1 ? one : many}`;

let toastTimer = 0;

export function say(message) {
  clearTimeout(toastTimer);
  byId("toast").textContent = message;
  toastTimer = setTimeout(() => { byId("toast").textContent = ""; }, 4000);
}

export function report(error) {
  if (error instanceof ServerError) say(error.message);
  else if (!(error instanceof TypeError)) throw error; // of fetch: the server is gone, which the banner tells
}

export async function copy(text, message) {
  try {
    await navigator.clipboard.writeText(text);
    say(message);
  } catch {
    say("The browser did not allow copying: select the text instead.");
  }
}
