// Machines in motion: one crank angle moves the drawing and the cursors of its curves.
const LEFT = 52, RIGHT = 386, TOP = 24, BOTTOM = 122; // of the area of a panel, see panels.py
const moving = new Map(); // machines that run, each with what it does a moment later

/** The row at a part of the way, between the two that are next to it. */
function rowAt(rows, share) {
  const at = share * (rows.length - 1), low = Math.floor(at), part = at - low;
  const one = rows[low], next = rows[Math.min(low + 1, rows.length - 1)];
  return one.map((value, k) => value + part * (next[k] - value));
}

/** The text of a number in three digits, and zero without a sign. */
function digits(value) {
  const size = Math.abs(value);
  return size && (size < 1e-3 || size >= 1e4) ? value.toExponential(1) : String(Number(value.toPrecision(3)));
}

/** Curves of a panel, each with its run and a function from a share of the range to the value there. */
function curvesOf(panel) {
  const low = Number(panel.dataset.low), high = Number(panel.dataset.high), log = panel.dataset.log;
  return [...panel.querySelectorAll("path[data-run]")].map((path) => {
    const points = path.getAttribute("d").slice(1).split(" ").map((one) => one.split(",").map(Number));
    return [path.dataset.run, (share) => {
      const x = LEFT + (RIGHT - LEFT) * share, next = points.findIndex((one) => one[0] >= x);
      if (next < 0 || (next === 0 && points[0][0] > x + 1)) return NaN;
      const [x1, y1] = points[next], [x0, y0] = points[Math.max(next - 1, 0)];
      const y = x1 > x0 ? y0 + (y1 - y0) * (x - x0) / (x1 - x0) : y1;
      const value = low + (high - low) * (BOTTOM - y) / (BOTTOM - TOP);
      return log ? 10 ** value : Math.abs(value) < 1e-3 * (high - low) ? 0 : value;
    }];
  });
}

function place(uses, poses) {
  for (const use of uses) {
    const [x, y, turn] = poses.slice(3 * use.dataset.body);
    use.setAttribute("transform", `translate(${x.toFixed(4)} ${y.toFixed(4)}) rotate(${turn.toFixed(5)})`);
  }
}

/** How far the observed point is off [mm], to first order: the difference of two places would be rounding. */
function offBy(data, exact, error) {
  const [body, x, y] = data.point, turn = exact[3 * body + 2] * Math.PI / 180;
  const arm = [Math.cos(turn) * x - Math.sin(turn) * y, Math.sin(turn) * x + Math.cos(turn) * y];
  const [dx, dy, degrees] = error.slice(3 * body, 3 * body + 3), by = degrees * Math.PI / 180;
  return data.mm * Math.hypot(dx - by * arm[1], dy + by * arm[0]);
}

const first = document.querySelector(".machine");
for (const root of document.querySelectorAll(".machine")) {
  const data = JSON.parse(root.querySelector("script").textContent);
  const form = root.querySelector("form"), slider = form.querySelector("input"), play = form.querySelector("button");
  const [ghost, engine] = ["ghost", "engine"].map((name) => [...root.querySelectorAll(`.${name} use`)]);
  const cursors = [...root.querySelectorAll(".cursor")], lines = [...root.querySelectorAll("path[data-run]")];
  const panels = [...root.querySelectorAll(".curves")].map((panel) => [panel.querySelector(".value"), curvesOf(panel)]);
  const { speed, run, power } = form.elements;
  let share = slider.value / 360;

  function show() {
    const exact = rowAt(data.exact, share), error = rowAt(data.runs[run.value].errors, share);
    place(ghost, exact);
    place(engine, exact.map((value, k) => value + 10 ** power.value * error[k]));
    const x = LEFT + (RIGHT - LEFT) * share, degrees = data.ends[0] + share * (data.ends[1] - data.ends[0]);
    for (const cursor of cursors) for (const name of ["x1", "x2"]) cursor.setAttribute(name, x);
    for (const [text, curves] of panels) {
      const [, at] = curves.find(([of]) => of === run.value || of === "-1") || [];
      const value = at ? at(share) : NaN;
      text.textContent = Number.isFinite(value) ? digits(value) : "";
    }
    const words = `${degrees.toFixed(0)} deg, off by ${offBy(data, exact, error).toPrecision(2)} mm`;
    root.querySelector(".now").textContent = `Crank angle ${words}.`;
    slider.setAttribute("aria-valuetext", words);
  }

  function choose() {
    root.querySelector(".run").textContent = run.selectedOptions[0].textContent;
    root.querySelector(".power").textContent = power.selectedOptions[0].textContent;
    for (const line of lines) line.classList.toggle("other", line.dataset.run !== run.value && line.dataset.run !== "-1");
    show();
  }

  function stop() {
    moving.delete(root);
    play.textContent = "Play";
  }

  function start() {
    play.textContent = "Pause";
    moving.set(root, (seconds) => {
      share = (share + seconds * speed.value) % 1;
      slider.value = Math.round(share * 360);
      show();
    });
  }

  slider.addEventListener("input", () => { stop(); share = slider.value / 360; show(); });
  run.addEventListener("change", () => { power.value = data.runs[run.value].power; choose(); });
  power.addEventListener("change", choose);
  play.addEventListener("click", () => (moving.has(root) ? stop() : start()));
  for (const panel of root.querySelectorAll(".curves")) {
    panel.addEventListener("pointermove", (event) => {
      const box = panel.getBoundingClientRect(), x = 400 * (event.clientX - box.left) / box.width;
      stop();
      share = Math.min(Math.max((x - LEFT) / (RIGHT - LEFT), 0), 1);
      slider.value = Math.round(share * 360);
      show();
    });
  }
  form.hidden = false;
  choose();
  if (root === first && !matchMedia("(prefers-reduced-motion: reduce)").matches) start();
}

let before = 0;
requestAnimationFrame(function frame(now) {
  for (const step of moving.values()) step((now - before) / 1000);
  before = now;
  requestAnimationFrame(frame);
});
