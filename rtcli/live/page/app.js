// The page of `rtcli live`: follows the server, and joins the parts.

import { make } from "/element.js";
import { showHistogram, stepExposure, toggleClipped } from "/exposure.js";
import { byId, copy, counted, emit, live, on, report } from "/live.js";
import { adaptSize, drag, drop, isCameraMode, step, toggleMode, wheel } from "/move.js";
import { flash, openObject } from "/objects.js";
import { clickPixel, followHash, hover, move, select, togglePin } from "/pixel.js";
import { Events, getJson, newest } from "/server.js";
import { openPanel } from "/tabs.js";
import { loadPicture, stage, takePicture } from "/view.js";

Object.assign(stage.handlers, { hover, select: clickPixel, drag, drop, wheel });
on("pixel", (pixel) => { if (pixel) openPanel("pixel"); });
on("mode", (isCamera) => { if (isCamera) openPanel("camera"); });

// --- State and picture -----------------------------------------------------------------------------------

let shown = null; // the event after which the picture on the screen was loaded

// They are fetched side by side, since the event says whether there is a new picture. The state may be newer than the
// event, so it does not tell which picture is on the screen.
const refresh = newest(async (event) => {
  const start = performance.now();
  const old = live.state;
  const isNew = event.picture !== null && (event.picture !== shown?.picture || event.preview !== shown.preview);
  const [state, picture] = await Promise.all([getJson("/state"), isNew ? loadPicture().catch(notShown) : null]);
  live.state = state;
  emit("state", old);
  if (!picture) return;
  const isSave = shown !== null && event.picture !== shown.picture;
  shown = event;
  await takePicture(picture);
  if (isSave) {
    showLatency(state.picture.milliseconds + performance.now() - start);
    flash(state.changed);
  }
}, report);

// The state is shown even if the server refuses the view: the pose of a moved camera, of a scene that changed.
function notShown(error) {
  report(error);
  return null;
}

// For another view of the same state.
const look = newest(async () => {
  const start = performance.now();
  await takePicture(await loadPicture());
  adaptSize(performance.now() - start);
}, report);

on("view", () => look());

function showLatency(milliseconds) {
  byId("latency").hidden = false;
  byId("latency").textContent = `${Math.round(milliseconds)} ms`;
}

const events = new Events({
  onEvent: refresh,
  onOpen: () => { byId("gone").hidden = true; },
  onGone: (seconds, isRefused) => {
    byId("gone").hidden = false;
    byId("gone").firstChild.textContent = isRefused
      ? "The server was started again: open the address that it printed."
      : `The server is gone. The page tries again every ${seconds} s.`;
  },
});
byId("retry").addEventListener("click", () => events.retry());

// --- Status and problems ---------------------------------------------------------------------------------

const STATUS = {
  ok: ({ picture }) => `Up to date, ${picture.time}`,
  rendering: () => "Rendering",
  invalid: ({ problems }) => counted(Math.max(problems.length, 1), "problem"),
  missing: () => "File not readable",
};

function showStatus(state) {
  const { status, picture, problems } = state;
  byId("status").className = `status ${status}`;
  byId("status").textContent = STATUS[status](state);
  const isStale = picture !== null && (status === "invalid" || status === "missing");
  byId("stage").classList.toggle("dimmed", isStale);
  byId("stale").hidden = !isStale;
  const where = status === "missing" ? "the file cannot be read" : problems.length ? `line ${problems[0].line}` : "not valid";
  if (isStale) byId("stale").textContent = `${where}: picture of ${picture.time}`;
  byId("empty").hidden = picture !== null || status !== "rendering";
  byId("preview").hidden = !picture?.preview;
}

// Errors are shown at once, warnings on demand.
function showProblems({ problems, report: text, status }) {
  const isOk = status === "ok" || status === "rendering";
  byId("warnings").hidden = !text || !isOk;
  byId("warnings").textContent = counted(problems.length, "warning");
  byId("problems").hidden = !text || (isOk && byId("warnings").ariaExpanded === "false");
  byId("problems").classList.toggle("bad", !isOk);
  byId("problems-title").textContent = isOk ? byId("warnings").textContent : STATUS[status]({ problems });
  if (byId("report").textContent !== text) byId("report").textContent = text;
}

function showName(path) {
  const end = Math.max(path.lastIndexOf("/"), path.lastIndexOf("\\")) + 1;
  byId("scene").replaceChildren(make("span", { className: "folder" }, path.slice(0, end)), path.slice(end));
  document.title = `${path.slice(end)} · rtcli live`;
}

on("state", () => {
  showName(live.state.scene);
  showStatus(live.state);
  showProblems(live.state);
});
byId("problems-toggle").addEventListener("click", () => {
  byId("report").hidden = !byId("report").hidden;
  byId("problems-toggle").ariaExpanded = String(!byId("report").hidden);
  byId("problems-toggle").textContent = byId("report").hidden ? "Show" : "Hide";
});
byId("warnings").addEventListener("click", () => {
  byId("warnings").ariaExpanded = String(byId("warnings").ariaExpanded === "false");
  showProblems(live.state);
});

// --- What differs from the file, and the command that gives the same picture -----------------------------

function showView() {
  const { pose, exposure } = live;
  const what = [pose && "camera", exposure !== null && "exposure"].filter(Boolean);
  byId("view-only").hidden = what.length === 0;
  byId("view-only").firstElementChild.textContent = `View only: ${what.join(" and ")}`;
  const parts = [live.state.command];
  if (exposure !== null) parts.push(`--exposure ${exposure}`);
  for (const name of pose ? ["position", "look_at", "up"] : []) parts.push(`--set 'camera.${name}=[${pose[name].join(", ")}]'`);
  const { matrix } = live.state.camera ?? {};
  byId("command").textContent = pose && matrix
    ? `# the file has camera.${matrix}, which options cannot replace: put the lines of the panel Camera there`
    : parts.join(" ");
}

function resetView() {
  Object.assign(live, { pose: null, exposure: null });
  emit("view");
}

on("state", showView);
on("view", showView);
byId("view-reset").addEventListener("click", resetView);
byId("command-copy").addEventListener("click", () => copy(byId("command").textContent, "The command is copied"));

// --- Theme -----------------------------------------------------------------------------------------------

const THEMES = ["system", "light", "dark"];
const root = document.documentElement;

function setTheme(theme) {
  root.dataset.theme = theme;
  localStorage.setItem("rtcli-theme", theme);
  byId("theme").textContent = `Theme: ${theme}`;
  showHistogram();
}

function nextTheme() {
  setTheme(THEMES[(THEMES.indexOf(root.dataset.theme) + 1) % THEMES.length]);
}

byId("theme").addEventListener("click", nextTheme);

// --- Keys ------------------------------------------------------------------------------------------------

function nextOption(select) {
  select.selectedIndex = (select.selectedIndex + 1) % select.options.length;
  select.dispatchEvent(new Event("change"));
}

function close() {
  if (live.opened !== null) openObject(null);
  else if (live.pin) togglePin();
  else if (live.pixel) select(null);
}

function arrow(x, y) {
  return ({ shiftKey }) => {
    if (isCameraMode()) step(shiftKey ? "pan" : "orbit", x, y);
    else move(shiftKey ? 10 * x : x, shiftKey ? 10 * y : y);
  };
}

// What the dialog shows, and what each key does.
const KEYS = [
  ["← ↑ ↓ →", "Move the pixel, or orbit the camera; with Shift: by 10, or pan", {
    ArrowLeft: arrow(-1, 0), ArrowRight: arrow(1, 0), ArrowUp: arrow(0, -1), ArrowDown: arrow(0, 1),
  }],
  ["P", "Pin the pixel, and put the next one beside it", { p: togglePin }],
  ["Esc", "Close the object, the pin, the pixel", { Escape: close }],
  ["+ −", "Zoom in, zoom out", { "+": () => stage.zoomIn(), "=": () => stage.zoomIn(), "-": () => stage.zoomOut() }],
  ["0 1", "Fit the picture, actual pixels", { 0: () => stage.fit(), 1: () => stage.actual() }],
  ["V", "Show the next pass", { v: () => nextOption(byId("pass")) }],
  ["D", "Compare with the picture before: next way", { d: () => nextOption(byId("compare")) }],
  ["H", "Hatch clipped pixels", { h: toggleClipped }],
  ["[ ]", "Exposure down, up by a quarter of a stop", { "[": () => stepExposure(-0.25), "]": () => stepExposure(0.25) }],
  ["C", "Switch between Inspect and Move camera", { c: toggleMode }],
  ["PgUp PgDn", "Camera closer, farther", { PageUp: () => step("dolly", 0, -1), PageDown: () => step("dolly", 0, 1) }],
  ["R", "Reset camera and exposure to those of the file", { r: resetView }],
  ["/", "Filter the objects", { "/": () => { openPanel("objects"); byId("find").focus(); } }],
  ["T", "Next theme", { t: nextTheme }],
  ["?", "Show this list", { "?": () => byId("keys").showModal() }],
];
const actions = Object.assign({}, ...KEYS.map(([, , each]) => each));

// These also scroll, or move what has the focus: they belong to the picture only while nothing else has it.
const SHARED = /^(Arrow|Page)/;
const TYPED = "input:not([type=radio], [type=range]), select";

document.addEventListener("keydown", (event) => {
  const { target, key } = event;
  if (event.ctrlKey || event.altKey || event.metaKey || !live.state || document.querySelector("dialog[open]")) return;
  if (target.matches(TYPED) || (SHARED.test(key) && target !== document.body && target !== byId("stage"))) return;
  const action = actions[key.length === 1 ? key.toLowerCase() : key];
  if (!action) return;
  event.preventDefault();
  action(event);
});

byId("keys-list").append(...KEYS.map(([keys, text]) => {
  const caps = keys.split(" ").map((key) => make("kbd", {}, key));
  return make("p", {}, make("i", {}, ...caps), make("span", {}, text));
}));
byId("help").addEventListener("click", () => byId("keys").showModal());
byId("keys-close").addEventListener("click", () => byId("keys").close());

on("panel", showHistogram);
setTheme(root.dataset.theme);
history.replaceState(null, "", location.pathname + location.hash); // the cookie has the token now
followHash();
