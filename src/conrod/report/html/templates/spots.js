// Figures that say of a place what is there: the nearest to the pointer, or one after the other by a slider.
const SVG = "http://www.w3.org/2000/svg";

for (const root of document.querySelectorAll(".spots")) {
  const { phrases, words, places } = JSON.parse(root.querySelector("script").textContent);
  const svg = root.querySelector("svg");
  const { width, height } = svg.viewBox.baseVal, ring = document.createElementNS(SVG, "circle");
  const label = document.createElement("label"), slider = document.createElement("input");
  const said = document.createElement("output");
  Object.assign(slider, { type: "range", min: 0, max: places.length - 1, value: 0 });
  label.append("Point ", slider);
  said.textContent = "Point at a place of the figure, or move the slider.";
  root.prepend(label, said);

  function show(k) {
    const [x, y, number] = places[k], text = words[number].map((phrase) => phrases[phrase]).join("");
    ring.setAttribute("cx", x * width);
    ring.setAttribute("cy", y * height);
    ring.setAttribute("r", 6);
    ring.setAttribute("class", "ring");
    svg.append(ring);
    slider.value = k;
    slider.setAttribute("aria-valuetext", text);
    said.textContent = text;
  }

  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
    const far = places.map((one) => Math.hypot((one[0] - x) * width, (one[1] - y) * height));
    show(far.indexOf(Math.min(...far)));
  });
  slider.addEventListener("input", () => show(slider.value));
}
