// Shows the story of a pixel, as `rtcli explain --json` tells it: a sentence, a drawing, and each step with its
// equations, the same with their numbers put in, and the result.
//
//   renderStory(element, story, {onHoverObject, onHoverLight, onHoverPath, onOpenLine}) -> a handle
//
// A symbol that is pointed at or has the focus lights up in the drawing, and the callbacks get the index of its object
// or light, and the path of the value in the scene's file that it comes from; null when it is left. onOpenLine gets
// the index of an object whose name is pressed. Text from scenes goes into the page by textContent only.

import { described, drawNumberLine, drawSection, heightOf, scaleNote, shown } from "./drawing.js";
import { make } from "./element.js";

const STEPS = [
  ["story", "ray"], ["story", "intersections"], ["story", "hit"], ["story", "lights"], ["story", "radiance"],
  ["development", "mean"], ["development", "exposure"], ["development", "tone"], ["development", "srgb"],
];

const MOST = 8; // objects and lights in full; the others are behind a button

// Where in the file the numbers come from that are neither of an object nor of a light.
const PATHS = {
  o: "camera.position", camera: "camera.position", d: "camera", r: "camera.look_at", u: "camera.up", f: "camera.look_at",
  fov: "camera.fov", height: "camera.height", focal: "camera", c: "camera", size: "camera.resolution", p: "camera.resolution",
  N: "render.samples", a: "render.samples", ambient: "render.ambient", EV: "image.exposure", factor: "image.exposure",
  y: "image.tone", alpha: "image.alpha",
};
const OF_OBJECT = { rho: "color", C: "position", R: "radius", p_0: "position", n: "normal", s_square: "checker", square: "checker" };
const OF_LIGHT = { position: "position", r: "position", l: "position", intensity: "intensity", irradiance: "irradiance", L_i: "intensity", color: "color" };

const VERDICTS = { lit: "✓ reaches the point", blocked: "✕ blocked", turned_away: "✕ faces away", other_side: "✕ other side" };

export function renderStory(element, story, callbacks = {}) {
  return new StoryView(element, story, callbacks).handle();
}

class StoryView {
  constructor(element, story, callbacks) {
    this.story = story;
    this.callbacks = callbacks;
    this.section = story.drawing.chosen;
    this.view = 0;
    this.root = make("article", { className: "story" });
    this.root.append(this.sentence(), this.drawing(), this.steps());
    element.replaceChildren(this.root);
    this.observe(element);
    for (const [name, isOn] of [["pointerover", true], ["pointerout", false], ["focusin", true], ["focusout", false]]) {
      this.root.addEventListener(name, (event) => this.point(event.target, isOn));
    }
    this.root.addEventListener("click", (event) => {
      const target = event.target.closest("[data-open]");
      if (target) this.callbacks.onOpenLine?.(Number(target.dataset.open));
    });
  }

  handle() {
    return {
      highlightSymbol: (name) => this.light(name === null ? null : `[data-symbol="${name}"]`),
      highlightObject: (index) => this.light(index === null ? null : `[data-object="${index}"]`),
      highlightLight: (index) => this.light(index === null ? null : `[data-light="${index}"]`),
      // What the reader chose to see in the drawing, for the story that follows; null before that.
      drawn: () => (this.isPicked ? [this.section, this.view] : null),
      draw: ([section, view]) => this.pick(section, view),
    };
  }

  // --- The sentence

  sentence() {
    const [red, green, blue] = this.story.value;
    const swatch = make("span", { className: "swatch" });
    swatch.style.backgroundColor = `rgb(${red} ${green} ${blue})`;
    const code = `#${this.story.value.map((x) => x.toString(16).padStart(2, "0")).join("")}`;
    return make("div", { className: "verdict" },
      swatch,
      make("p", { className: "sentence", textContent: this.story.sentence }),
      make("p", { className: "value", textContent: `Pixel ${this.story.pixel.join(",")}: ${this.story.value.join(" ")}, ${code}` }));
  }

  // --- The drawing

  drawing() {
    const { sections } = this.story.drawing;
    this.canvas = make("div", { className: "canvas" });
    this.caption = make("figcaption");
    this.tools = make("div", { className: "drawing-tools" });
    if (sections.length > 1) {
      const choices = sections.map(({ shadow_ray: way }, i) => [`${way.label} ${VERDICTS[way.verdict].slice(0, 1)}`, i]);
      this.tools.append(this.choice("Section through", choices, () => this.section, (i) => this.pick(i, 0)));
    }
    this.zoom = make("button", { type: "button", className: "zoom" });
    this.zoom.addEventListener("click", () => this.pick(this.section, 1 - this.view));
    this.tools.append(this.zoom);
    return make("figure", { className: "drawing" }, this.tools, this.canvas, this.caption);
  }

  pick(section, view) {
    const { sections } = this.story.drawing;
    if (!(view in (sections[section]?.views ?? []))) return;
    Object.assign(this, { section, view, isPicked: true });
    this.draw();
  }

  choice(legend, choices, get, set) {
    const name = `story-${legend}-${Math.random().toString(36).slice(2)}`;
    const labels = choices.map(([text, value]) => {
      const input = make("input", { type: "radio", name, checked: value === get() });
      input.addEventListener("change", () => set(value));
      return make("label", {}, input, make("span", { textContent: text }));
    });
    return make("fieldset", { className: "sections" }, make("legend", { textContent: legend }), ...labels);
  }

  observe(element) {
    this.width = 0;
    const redraw = () => {
      const width = Math.round(this.canvas.clientWidth);
      if (width > 0 && width !== this.width) {
        this.width = width;
        this.draw();
      }
    };
    redraw();
    if (typeof ResizeObserver !== "undefined") new ResizeObserver(redraw).observe(this.canvas);
  }

  draw() {
    const { drawing } = this.story;
    const section = drawing.sections[this.section];
    const pictures = [];
    this.zoom.hidden = !section || section.views.length < 2;
    this.zoom.textContent = this.view === 0 ? "Zoom to the point" : "Show all";
    this.caption.textContent = section ? described(drawing, section) : "The numbers of this story are too large to be drawn.";
    if (section) {
      const size = [this.width, Math.max(...drawing.sections.map((each) => heightOf(each, 0, this.width)))];
      const picture = drawSection(drawing, section, this.view, size);
      picture.setAttribute("aria-label", `Drawing. ${this.caption.textContent}`);
      pictures.push(picture);
    }
    const line = drawNumberLine(drawing, this.width);
    if (line) {
      line.setAttribute("aria-label", line.querySelector("title").textContent);
      const note = scaleNote(drawing);
      pictures.push(line, ...(note ? [make("p", { className: "note", textContent: note })] : []));
    }
    this.canvas.replaceChildren(...pictures);
    this.root.querySelectorAll(".sections input").forEach((input, i) => { input.checked = i === this.section; });
  }

  // --- The steps

  steps() {
    const items = STEPS.map(([part, name]) => this.step(name, this.story[part][name]));
    return make("ol", { className: "steps" }, ...items);
  }

  step(name, step) {
    const item = make("li", { className: "step" },
      make("h3", {}, step.title, make("span", { className: "of", textContent: ` ${step.section}` })));
    const context = name === "hit" || name === "radiance" ? { object: this.story.story.hit.object?.index } : {};
    const objects = step.objects ?? [];
    const lights = step.lights ?? [];
    const nearest = objects.find(({ verdict }) => verdict === "nearest");
    if (nearest) item.append(this.object(nearest));
    if (objects.length + lights.length === 0) item.append(...this.formulas(step, context));
    item.append(this.numbers(step, context));
    const others = objects.filter((each) => each !== nearest);
    const behind = others.filter(({ t }) => t !== null).sort((a, b) => a.t - b.t);
    const missed = others.filter(({ t }) => t === null);
    item.append(...this.list([...behind, ...missed], (each) => this.object(each), "objects"));
    item.append(...this.list(lights.map((each, i) => [each, i]), ([each, i]) => this.lightItem(each, i), "lights"));
    if (name === "mean" && step.groups.length > 1) item.append(this.groups(step.groups));
    if (step.note) item.append(make("p", { className: "aside", textContent: step.note }));
    item.append(make("p", { className: "outcome" }, make("span", { ariaHidden: "true", textContent: "⇒ " }), step.outcome));
    return item;
  }

  list(items, show, name) {
    if (items.length === 0) return [];
    const list = make("ul", { className: name }, ...items.slice(0, MOST).map(show));
    const rest = items.slice(MOST);
    if (rest.length === 0) return [list];
    const more = make("button", { type: "button", textContent: `Show ${rest.length.toLocaleString("en")} more ${name}` });
    more.addEventListener("click", () => {
      list.append(...rest.map(show));
      more.remove();
    });
    return [list, more];
  }

  object(item) {
    const { object } = item;
    const context = { object: object.index };
    const t = item.t === null ? "missed" : `t = ${shown(item.t)}`;
    const isNearest = item.verdict === "nearest";
    return make(isNearest ? "div" : "li", { className: `item object ${item.verdict}`, dataset: { object: object.index } },
      make("p", { className: "item-head" }, this.name(object.label, object), make("b", { textContent: ` ${t} ` }), item.outcome),
      ...(isNearest ? this.formulas(item, context) : []),
      isNearest ? this.numbers(item, context) : "");
  }

  lightItem(light, index) {
    const context = { light: index, object: light.body?.index };
    return make("li", { className: `item light ${light.verdict}`, dataset: { light: index } },
      make("p", { className: "item-head" }, this.name(light.label, light.body, index), make("b", { textContent: ` ${VERDICTS[light.verdict]} ` }), light.outcome),
      ...this.formulas(light, context),
      this.numbers(light, context));
  }

  // The name of an object or a light; pressing it opens the object's lines.
  name(label, object, light) {
    const dataset = { ...(light !== undefined && { light }), ...(object && { object: object.index, open: object.index }) };
    return make("button", { type: "button", className: "name", textContent: label, dataset });
  }

  formulas(step, context) {
    const worked = (step.formulas ?? []).filter((each) => each.terms.length > 0);
    return worked.length === 0 ? [] : [make("div", { className: "formulas" }, ...worked.map((each) => this.formula(each, context)))];
  }

  formula({ terms, worked, result }, context) {
    const line = make("p", { className: "equation" }, ...terms.map((term) => this.term(term, context)));
    if (!worked) return make("div", {}, line);
    const equal = make("p", { className: "worked" }, "=\u00a0", ...worked.map((term) => this.term(term, context)));
    const isNews = result && result !== worked.map((term) => term.text ?? term).join("");
    if (isNews) equal.append(" =\u00a0", make("b", { textContent: result }));
    return make("div", {}, line, equal);
  }

  term(term, context) {
    if (typeof term === "string") return term;
    if (!term.symbol) return term.text;
    return make("span", { className: "symbol", textContent: term.text, dataset: this.data(term.symbol, context) });
  }

  data(symbol, { light, object }) {
    return { symbol, ...(light !== undefined && { light }), ...(object !== undefined && { of: object }) };
  }

  numbers(step, context) {
    const rows = Object.entries(step.numbers ?? {}).map(([name, value]) => {
      const symbol = make("button", {
        type: "button", className: "symbol", textContent: this.story.symbols[name] ?? name, dataset: this.data(name, context),
      });
      const values = (Array.isArray(value) ? value : [value]).map((x) => (x === null ? "∞" : shown(x)));
      return make("tr", {},
        make("th", { scope: "row" }, symbol),
        make("td", { className: "number", textContent: values.map((x) => x.padEnd(9)).join(" ").trimEnd() }),
        make("td", { textContent: step.meanings?.[name] ?? "" }));
    });
    return rows.length === 0 ? "" : make("div", { className: "scroll" }, make("table", {}, make("tbody", {}, ...rows)));
  }

  groups(groups) {
    const items = groups.slice(0, MOST).map(({ object, count, radiance }) => make("li", {},
      make("b", { textContent: `${count} × ` }),
      object ? this.name(object.label, object) : "the background",
      ` ${radiance.map((x) => shown(x ?? Infinity)).join("  ")}`));
    return make("ul", { className: "groups" }, ...items);
  }

  // --- Pointing at symbols

  point(target, isOn) {
    const place = target.closest("[data-symbol], [data-object], [data-light]");
    if (!place || !this.root.contains(place)) return;
    const { symbol, object, light, of } = place.dataset;
    if (!isOn) {
      this.light(null);
      this.callbacks.onHoverObject?.(null);
      this.callbacks.onHoverLight?.(null);
      this.callbacks.onHoverPath?.(null);
      return;
    }
    if (light !== undefined) this.turnTo(Number(light));
    const isOfLight = light !== undefined && (symbol === undefined || symbol in OF_LIGHT || symbol === "share");
    if (symbol !== undefined && symbol !== "object") {
      const sameLight = light === undefined || !place.closest(".steps") ? "" : `:not([data-light]), [data-symbol="${symbol}"][data-light="${light}"]`;
      this.light(sameLight ? `[data-symbol="${symbol}"]${sameLight}` : `[data-symbol="${symbol}"]`);
    } else if (object !== undefined) {
      this.light(`[data-object="${object}"]`);
    } else {
      this.light(`[data-light="${light}"]`);
    }
    const seen = this.story.story.hit.object?.index;
    const index = object ?? (isOfLight || symbol in PATHS ? undefined : of) ?? (["t", "P", "n", "rho"].includes(symbol) ? seen : undefined);
    if (isOfLight) this.callbacks.onHoverLight?.(Number(light));
    if (index !== undefined) this.callbacks.onHoverObject?.(Number(index));
    this.callbacks.onHoverPath?.(this.path(symbol, index, isOfLight ? light : undefined));
  }

  path(symbol, object, light) {
    if (light !== undefined) {
      const body = this.story.story.lights.lights[light]?.body;
      const start = body ? `objects[${body.index}]` : `lights[${light}]`;
      return symbol in OF_LIGHT ? `${start}.${OF_LIGHT[symbol]}` : start;
    }
    if (object !== undefined) return symbol in OF_OBJECT ? `objects[${object}].${OF_OBJECT[symbol]}` : `objects[${object}]`;
    return PATHS[symbol] ?? null;
  }

  turnTo(light) {
    const section = this.story.drawing.sections.findIndex(({ shadow_ray: way }) => way?.light === light);
    if (section < 0 || section === this.section) return;
    this.section = section;
    this.view = 0;
    this.draw();
  }

  light(selector) {
    this.root.querySelectorAll(".is-lit").forEach((each) => each.classList.remove("is-lit"));
    if (selector) this.root.querySelectorAll(selector).forEach((each) => each.classList.add("is-lit"));
  }
}
