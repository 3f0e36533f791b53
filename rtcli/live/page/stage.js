// The picture on a canvas: zoom, pan, and what is drawn over it. "Screen" means CSS pixels of the stage.

const MOST = 64;
const STEP = Math.SQRT2;
const MANY = 8e6; // pixels of an enlarged copy
const GRIP = 16; // pixels beside the border of the slider that take hold of it
const CLICK = 4; // pixels that a pointer may move between down and up

export class Stage {
  // `handlers`: hover(pixel or null), select(pixel, event), drag(dx, dy, event), wheel(event), drop(), slide(share); `drag` and
  // `wheel` return true if they took the event. `overlays` draw over an image: functions of a context and a port.
  constructor(element, canvas, onZoom) {
    Object.assign(this, { element, canvas, onZoom, handlers: {}, overlays: [] });
    this.context = canvas.getContext("2d");
    this.images = []; // one, or before and now
    this.layout = "one"; // or "sides" or "slider"
    this.split = 0.5;
    this.width = this.height = 0; // of the picture
    this.scale = 1;
    this.center = { x: 0, y: 0 }; // the point of the picture in the middle
    this.isFitted = true;
    this.frame = 0;
    this.large = new WeakMap();
    new ResizeObserver(() => this.resize()).observe(element);
    this.listen();
  }

  get ratio() {
    return window.devicePixelRatio || 1;
  }

  // Swaps what is shown; zoom and place stay, unless the size of the picture is another.
  show(images, width, height, layout = "one") {
    const isSameSize = width === this.width && height === this.height;
    Object.assign(this, { images, width, height });
    if (layout !== this.layout || !isSameSize) {
      this.layout = layout;
      if (!isSameSize && !this.isFitted) this.moveCenter(width / 2, height / 2);
      if (this.isFitted) this.fit();
    }
    this.draw();
  }

  resize() {
    const { clientWidth, clientHeight } = this.element;
    this.canvas.width = Math.round(clientWidth * this.ratio);
    this.canvas.height = Math.round(clientHeight * this.ratio);
    if (this.isFitted) this.fit();
    this.drawNow(); // in the same frame, since setting a canvas's size clears it
  }

  // --- Zoom and place ------------------------------------------------------------------------------------

  get fitScale() {
    const columns = this.layout === "sides" ? 2 : 1;
    const { clientWidth, clientHeight } = this.element;
    return Math.min(clientWidth / columns / this.width, clientHeight / this.height) || 1;
  }

  fit() {
    this.isFitted = true;
    this.scale = this.fitScale;
    this.moveCenter(this.width / 2, this.height / 2);
  }

  actual() {
    this.zoom(1 / this.ratio / this.scale);
  }

  zoomIn(at) {
    this.zoom(STEP, at);
  }

  zoomOut(at) {
    this.zoom(1 / STEP, at);
  }

  // Keeps the point of the picture under `at`, a place on the screen.
  zoom(factor, at = null) {
    const scale = Math.min(Math.max(this.scale * factor, Math.min(this.fitScale, 1) / 4), MOST);
    this.isFitted = false;
    const port = this.portAt(at?.x ?? 0);
    const middle = at ?? port.middle;
    const point = this.pointAt(middle, port);
    this.scale = scale;
    this.moveCenter(point.x - (middle.x - port.middle.x) / scale, point.y - (middle.y - port.middle.y) / scale);
  }

  pan(dx, dy) {
    this.isFitted = false;
    this.moveCenter(this.center.x - dx / this.scale, this.center.y - dy / this.scale);
  }

  moveCenter(x, y) {
    this.center = { x: Math.min(Math.max(x, 0), this.width), y: Math.min(Math.max(y, 0), this.height) };
    this.onZoom();
    this.draw();
  }

  // Moves a pixel into sight.
  reveal({ x, y }) {
    const { middle, area } = this.ports()[0] ?? {};
    if (!area) return;
    const [half, quarter] = [{ x: area.width / 2 / this.scale, y: area.height / 2 / this.scale }, 0.9];
    const near = (value, center, reach) => Math.min(Math.max(center, value - reach * quarter), value + reach * quarter);
    const [nextX, nextY] = [near(x + 0.5, this.center.x, half.x), near(y + 0.5, this.center.y, half.y)];
    if (middle && (nextX !== this.center.x || nextY !== this.center.y)) {
      this.isFitted = false;
      this.moveCenter(nextX, nextY);
    }
  }

  // --- Ports: the parts of the stage that show an image --------------------------------------------------

  ports() {
    const { clientWidth: width, clientHeight: height } = this.element;
    const port = (image, left, right, middle) => ({
      image, area: { left, top: 0, width: right - left, height }, middle: { x: middle, y: height / 2 },
    });
    const [first, second] = this.images;
    if (!first) return [];
    if (this.layout === "sides") return [port(first, 0, width / 2, width / 4), port(second, width / 2, width, 0.75 * width)];
    if (this.layout === "slider") {
      const border = width * this.split;
      return [port(first, 0, border, width / 2), port(second, border, width, width / 2)];
    }
    return [port(first, 0, width, width / 2)];
  }

  portAt(x) {
    const ports = this.ports();
    const middle = { x: this.element.clientWidth / 2, y: this.element.clientHeight / 2 };
    return ports.find(({ area }) => x < area.left + area.width) ?? ports.at(-1) ?? { middle };
  }

  pointAt(place, port = this.portAt(place.x)) {
    return {
      x: this.center.x + (place.x - port.middle.x) / this.scale,
      y: this.center.y + (place.y - port.middle.y) / this.scale,
    };
  }

  pixelAt(event) {
    const box = this.element.getBoundingClientRect();
    const point = this.pointAt({ x: event.clientX - box.left, y: event.clientY - box.top });
    const [x, y] = [Math.floor(point.x), Math.floor(point.y)];
    return x >= 0 && y >= 0 && x < this.width && y < this.height ? { x, y } : null;
  }

  // --- Drawing -------------------------------------------------------------------------------------------

  draw() {
    if (!this.frame) this.frame = requestAnimationFrame(() => this.drawNow());
  }

  drawNow() {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    const { context, ratio, canvas } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    for (const port of this.ports()) {
      const { area, middle, image } = port;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.save();
      context.beginPath();
      context.rect(area.left, area.top, area.width, area.height);
      context.clip();
      // To whole pixels of the screen, so that pixels of the picture have sharp edges.
      port.left = Math.round((middle.x - this.center.x * this.scale) * ratio) / ratio;
      port.top = Math.round((middle.y - this.center.y * this.scale) * ratio) / ratio;
      const enlarged = this.enlarged(image, (this.scale * ratio * this.width) / image.width);
      context.imageSmoothingQuality = "high";
      context.imageSmoothingEnabled = enlarged.isSmooth;
      context.drawImage(enlarged.image, port.left, port.top, this.width * this.scale, this.height * this.scale);
      for (const overlay of this.overlays) {
        context.save();
        overlay(context, port);
        context.restore();
      }
      context.restore();
    }
    if (this.layout === "slider") this.drawHandle();
  }

  // Pixels that are enlarged have sharp edges and, at a scale between 1 and 3, all the same size: they are enlarged
  // to a whole number first, and then reduced.
  enlarged(image, scale) {
    const times = Math.ceil(scale);
    if (scale <= 1 || scale >= 3 || scale === times || image.width * image.height * times ** 2 > MANY) {
      return { image, isSmooth: scale < 1 };
    }
    const known = this.large.get(image);
    if (known?.times === times) return { image: known.canvas, isSmooth: true };
    const canvas = new OffscreenCanvas(image.width * times, image.height * times);
    const context = canvas.getContext("2d");
    context.imageSmoothingEnabled = false;
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    this.large.set(image, { times, canvas });
    return { image: canvas, isSmooth: true };
  }

  drawHandle() {
    const { context, element, ratio } = this;
    const x = element.clientWidth * this.split;
    const y = element.clientHeight / 2;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (const [color, grow] of [["#000", 1.5], ["#fff", 0]]) {
      context.fillStyle = color;
      context.fillRect(x - 1 - grow, 0, 2 + 2 * grow, element.clientHeight);
      context.beginPath();
      context.arc(x, y, 12 + grow, 0, 7);
      context.fill();
    }
    context.fillStyle = "#000";
    for (const way of [-1, 1]) {
      context.beginPath();
      context.moveTo(x + 8 * way, y);
      context.lineTo(x + 3 * way, y - 5);
      context.lineTo(x + 3 * way, y + 5);
      context.fill();
    }
  }

  // --- Pointer -------------------------------------------------------------------------------------------

  listen() {
    const { element, canvas, handlers } = this;
    let start = null;
    let hasMoved = false;
    let isSliding = false;
    const isAtBorder = (event) => {
      const { left, width } = element.getBoundingClientRect();
      return this.layout === "slider" && Math.abs(event.clientX - left - width * this.split) < GRIP;
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button > 1) return;
      element.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      start = { x: event.clientX, y: event.clientY };
      hasMoved = false;
      isSliding = isAtBorder(event);
      event.preventDefault();
    });
    canvas.addEventListener("pointermove", (event) => {
      handlers.hover(this.pixelAt(event));
      if (!start) canvas.classList.toggle("at-border", isAtBorder(event));
      if (!start) return;
      const [dx, dy] = [event.clientX - start.x, event.clientY - start.y];
      if (!hasMoved && Math.hypot(dx, dy) < CLICK) return;
      hasMoved = true;
      start = { x: event.clientX, y: event.clientY };
      if (isSliding) {
        const { left, width } = element.getBoundingClientRect();
        handlers.slide(Math.min(Math.max((event.clientX - left) / width, 0), 1));
      } else if (!handlers.drag(dx, dy, event)) {
        this.pan(dx, dy);
      }
    });
    canvas.addEventListener("pointerup", (event) => {
      const pixel = this.pixelAt(event);
      if (start && !hasMoved && pixel) handlers.select(pixel, event);
      if (hasMoved) handlers.drop();
      start = null;
    });
    canvas.addEventListener("pointercancel", () => { start = null; });
    canvas.addEventListener("pointerleave", () => handlers.hover(null));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      if (handlers.wheel(event)) return;
      const box = element.getBoundingClientRect();
      const step = event.deltaMode ? event.deltaY * 30 : event.deltaY;
      this.zoom(2 ** (-step / 240), { x: event.clientX - box.left, y: event.clientY - box.top });
    }, { passive: false });
  }
}
