// A click on a strip writes its moment into the first empty field. Without this, seconds are typed.
const strips = document.querySelector("[data-strips]");
const form = document.querySelector("#marks");
const said = form?.querySelector("[data-said]");

// The moment under a pointer: the drawing knows its own units, and where its axis lies in them.
function moment(svg, figure, clientX) {
  const box = svg.getBoundingClientRect();
  const width = svg.viewBox.baseVal.width;
  const [left, right] = [Number(strips.dataset.left), Number(strips.dataset.right)];
  const share = (((clientX - box.left) / box.width) * width - left) / (width - left - right);
  const [from, to] = [Number(figure.dataset.from), Number(figure.dataset.to)];
  return share >= 0 && share <= 1 ? from + share * (to - from) : null;
}

function draw(svg, clientX) {
  const box = svg.getBoundingClientRect();
  const axis = svg.querySelector("line.axis");
  const x = ((clientX - box.left) / box.width) * svg.viewBox.baseVal.width;
  const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
  const [top, bottom] = [24, Number(axis.getAttribute("y2"))];
  for (const [name, value] of Object.entries({ class: "own-mark", x1: x, x2: x, y1: top, y2: bottom })) line.setAttribute(name, value);
  svg.append(line);
}

strips?.addEventListener("click", (event) => {
  const svg = event.target.closest("svg");
  if (!svg) return;
  const t = moment(svg, svg.closest("figure"), event.clientX);
  const field = [...form.querySelectorAll("[name=mark]")].find((input) => input.value.trim() === "");
  if (t === null) return;
  if (!field) {
    said.textContent = said.dataset.full;
    return;
  }
  field.value = t.toFixed(2);
  draw(svg, event.clientX);
  said.textContent = `${field.labels[0].textContent.trim()}: ${field.value} s; ${said.dataset.unsaved}`;
});
