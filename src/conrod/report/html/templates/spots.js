// Figures that say of a place what is there: the nearest to the pointer, until a click holds it, or by a slider.
const SVG = "http://www.w3.org/2000/svg";

async function unpacked(text) {
  const packed = new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt())]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("deflate"))).json();
}

for (const root of document.querySelectorAll(".spots")) {
  const [across, down, texts] = await unpacked(root.querySelector("script").textContent);
  const svg = root.querySelector("svg");
  const { width, height } = svg.viewBox.baseVal, ring = document.createElementNS(SVG, "circle");
  const label = document.createElement("label"), slider = document.createElement("input");
  const said = document.createElement("output");
  let held = false;
  Object.assign(slider, { type: "range", min: 0, max: texts.length - 1, value: 0 });
  label.append("Point ", slider);
  said.textContent = "Point at a place of the figure, or move the slider.";
  root.prepend(label, said);

  function show(k) {
    ring.setAttribute("cx", across[k] * width);
    ring.setAttribute("cy", down[k] * height);
    ring.setAttribute("r", 6);
    ring.setAttribute("class", "ring");
    svg.append(ring);
    slider.value = k;
    slider.setAttribute("aria-valuetext", texts[k]);
    said.textContent = texts[k];
  }

  function showNearest(event) {
    const box = svg.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
    const far = texts.map((_, k) => Math.hypot((across[k] - x) * width, (down[k] - y) * height));
    show(far.indexOf(Math.min(...far)));
  }

  svg.addEventListener("pointermove", (event) => held || showNearest(event));
  svg.addEventListener("click", (event) => { held = !held; showNearest(event); });
  slider.addEventListener("input", () => show(slider.value));
}
