// The text of the scene file: line numbers, quiet colors, marked lines.

const PARTS = /("(?:[^"\\]|\\.)*"|'(?:[^']|'')*')|((?:^|\s)#.*$)|([\w.-]+(?=:(?:\s|$)))/g;

function fill(line, text) {
  const parts = [];
  let end = 0;
  const span = (name, content) => {
    const element = document.createElement("span");
    element.className = name;
    element.textContent = content;
    parts.push(element);
  };
  for (const match of text.matchAll(PARTS)) {
    parts.push(text.slice(end, match.index));
    end = match.index + match[0].length;
    if (match[1]) span("string", match[1]);
    else if (match[2]) span("comment", match[2]);
    else span("yaml-key", match[3]);
  }
  parts.push(text.slice(end) || (end ? "" : "\u200b"));
  line.replaceChildren(...parts);
}

export class Source {
  // `onHover` gets the number of the line under the pointer, or null.
  constructor(element, onHover) {
    this.element = element;
    this.texts = [];
    element.addEventListener("pointermove", (event) => {
      const line = event.target.closest?.(".line");
      onHover(line ? Number(line.dataset.number) : null);
    });
    element.addEventListener("pointerleave", () => onHover(null));
  }

  // Changes only the lines that changed, so that the place in the text stays.
  show(text) {
    const texts = text.replace(/\r\n?/g, "\n").replace(/\n$/, "").split("\n");
    const { children } = this.element;
    while (children.length > texts.length) this.element.lastChild.remove();
    texts.forEach((each, index) => {
      if (this.texts[index] === each && children[index]) return;
      let line = children[index];
      if (!line) {
        line = document.createElement("div");
        line.className = "line";
        line.dataset.number = index + 1;
        this.element.append(line);
      }
      fill(line, each);
    });
    this.texts = texts;
    this.element.style.setProperty("--digits", String(texts.length).length);
  }

  // `lines` as [first, last], or null to mark none.
  mark(name, lines) {
    const [first, last] = lines ?? [1, 0];
    this.markAll(name, Array.from({ length: last - first + 1 }, (_, index) => first + index));
  }

  markAll(name, numbers) {
    for (const line of this.element.querySelectorAll(`.${name}`)) line.classList.remove(name);
    for (const number of numbers) this.element.children[number - 1]?.classList.add(name);
  }

  // The line with a key among some lines, as [first, last]; all of them if it is not there.
  linesOf(key, [first, last]) {
    const pattern = new RegExp(`(^|[\\s{,])${key}\\s*:`);
    const number = this.texts.slice(first - 1, last).findIndex((text) => pattern.test(text)) + first;
    return number < first ? [first, last] : [number, number];
  }

  reveal([first]) {
    const line = this.element.children[first - 1];
    if (!line) return;
    const { scrollTop, clientHeight } = this.element;
    const top = line.offsetTop;
    if (top < scrollTop || top + line.offsetHeight > scrollTop + clientHeight) {
      this.element.scrollTop = top - clientHeight / 4;
    }
  }
}
