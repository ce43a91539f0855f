// Figures that say of a place what is there: the nearest to the pointer, until a click holds it, or by a slider. The
// first line of a text is said, and what follows stands below the figure, to be copied.
async function unpacked(text) {
  const packed = new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt())]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("deflate"))).json();
}

for (const root of document.querySelectorAll(".spots")) {
  const [across, down, ...parts] = await unpacked(root.querySelector("script").textContent);
  const texts = across.map((_, k) => parts.map((part) => part[k]).filter(Boolean).join(", "));
  const [label, slider, said, lines, ring] = ["label", "input", "output", "pre", "i"].map((tag) => document.createElement(tag));
  const figure = root.querySelector("img");
  let held = false;
  Object.assign(slider, { type: "range", min: 0, max: texts.length - 1, value: 0 });
  Object.assign(ring, { className: "ring", hidden: true });
  label.append("Point ", slider);
  said.textContent = "Point at a place of the figure, or move the slider.";
  Object.assign(lines, { tabIndex: 0, hidden: true });
  lines.setAttribute("aria-label", "Settings to paste");
  root.prepend(label, said);
  root.append(lines);
  figure.after(ring);

  function show(k) {
    ring.hidden = false;
    // In lengths of the picture, which may be wider than the box that it scrolls in.
    ring.style.left = `${figure.offsetWidth * across[k]}px`;
    ring.style.top = `${figure.offsetHeight * down[k]}px`;
    slider.value = k;
    const [first, ...more] = texts[k].split("\n");
    slider.setAttribute("aria-valuetext", first);
    said.textContent = first;
    lines.textContent = more.join("\n");
    lines.hidden = !lines.textContent;
  }

  function showNearest(event) {
    const box = figure.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const far = texts.map((_, k) => Math.hypot(across[k] * box.width - x, down[k] * box.height - y));
    show(far.indexOf(Math.min(...far)));
  }

  figure.addEventListener("pointermove", (event) => held || showNearest(event));
  figure.addEventListener("click", (event) => { held = !held; showNearest(event); });
  slider.addEventListener("input", () => show(slider.value));
  addEventListener("resize", () => ring.hidden || show(slider.value));
}
