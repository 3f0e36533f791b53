// The picture on its stage: passes, comparison with the picture before, zoom.

import { number, viridis } from "/color.js";
import { make } from "/element.js";
import { Picture, difference } from "/image.js";
import { byId, counted, emit, fullSize, live, loadPass, on, pictureQuery, report } from "/live.js";
import { PASSES, paint } from "/passes.js";
import { ServerError, get, newest } from "/server.js";
import { Stage } from "/stage.js";

export const stage = new Stage(byId("stage"), byId("canvas"), () => {
  byId("zoom").textContent = `${Number((stage.scale * stage.ratio * 100).toPrecision(3))} %`;
});

// The pass or the difference on the screen, for the value under the pointer.
export const shown = { pass: null, differs: null };

let retired = []; // pictures that may still be on the screen
let before = null; // a promise of the picture before

export async function loadPicture(query = pictureQuery()) {
  return Picture.of(await get("/picture", query));
}

function loadBefore() {
  before ??= loadPicture({ ...pictureQuery(), version: "previous" }).catch((error) => {
    if (error instanceof ServerError) return null; // the first good version has none before it
    throw error;
  });
  return before;
}

export async function takePicture(picture) {
  if (live.picture) retired.push(live.picture);
  live.picture = picture;
  before = null;
  live.passes.clear();
  await present();
  await new Promise(requestAnimationFrame); // the picture first, and then what is said of it
  setTimeout(() => emit("picture"));
  retired = retired.filter(({ bitmap }) => {
    const isShown = stage.images.includes(bitmap);
    if (!isShown) bitmap.close();
    return isShown;
  });
}

// Returns images, layout and legend of a comparison, loading what is missing.
async function compare(way) {
  const now = { images: [live.picture.bitmap] };
  const old = await loadBefore();
  if (!old) return { ...now, legend: { text: "There is no earlier picture: save a change first." } };
  if (way !== "difference") return { images: [old.bitmap, live.picture.bitmap], layout: way };
  const differs = difference(old, live.picture);
  if (!differs) return { ...now, legend: { text: "The picture before has another size." } };
  const found = { images: [differs.canvas], differs };
  if (!differs.count) return { ...found, legend: { text: "No pixel differs." } };
  const unit = `levels of 255, the largest of three channels; ${counted(differs.count, "pixel differs", "pixels differ")}`;
  return { ...found, legend: { low: 1, high: differs.most, unit } };
}

async function compose() {
  const name = byId("pass").value;
  if (name !== "picture") {
    const values = await loadPass(name);
    const { canvas, legend } = paint(name, values);
    return { images: [canvas], legend, pass: { name, values } };
  }
  const way = byId("compare").value;
  return way === "off" ? { images: [live.picture.bitmap] } : compare(way);
}

let turn = 0;

async function present() {
  if (!live.picture) return;
  const own = ++turn;
  const { images, layout = "one", legend = null, pass = null, differs = null } = await compose();
  if (own !== turn) return; // a newer one is on its way, or was faster
  Object.assign(shown, { pass, differs });
  const { width, height } = fullSize();
  stage.show(images, width, height, layout);
  stage.drawNow();
  showLegend(legend);
  byId("split").hidden = layout !== "slider";
  byId("side-before").hidden = byId("side-now").hidden = layout === "one";
  byId("side-now").textContent = `now, ${live.state.picture.time}`;
}

function showLegend(legend) {
  const place = byId("legend");
  place.hidden = !legend;
  if (!legend) return;
  if (legend.text) {
    place.replaceChildren(legend.text);
    return;
  }
  const bar = make("canvas", { width: 128, height: 1, ariaHidden: "true" });
  const context = bar.getContext("2d");
  for (let x = 0; x < bar.width; x++) {
    context.fillStyle = `rgb(${viridis(x / (bar.width - 1))})`;
    context.fillRect(x, 0, 1, 1);
  }
  const [low, high] = [legend.low, legend.high].map((value) => make("b", {}, number(value, 3)));
  place.replaceChildren(low, bar, high, make("span", {}, legend.unit));
}

const presentNewest = newest(async () => {
  await present();
  emit("shown");
}, report);

byId("pass").append(
  new Option("picture", "picture"),
  ...Object.entries(PASSES).map(([name, { title }]) => new Option(title, name)),
);
byId("pass").addEventListener("change", presentNewest);
byId("compare").addEventListener("change", () => {
  if (byId("compare").value !== "off") byId("pass").value = "picture";
  presentNewest();
});
function slide(share) {
  byId("split").value = 100 * share;
  stage.split = share;
  stage.draw();
}

stage.handlers.slide = slide;
byId("split").addEventListener("input", () => slide(byId("split").value / 100));

byId("zoom-in").addEventListener("click", () => stage.zoomIn());
byId("zoom-out").addEventListener("click", () => stage.zoomOut());
byId("zoom-fit").addEventListener("click", () => stage.fit());
byId("zoom-actual").addEventListener("click", () => stage.actual());

on("light", () => stage.draw());
on("open", () => stage.draw());
