// Machines in motion: one crank angle moves the drawing and the cursors of its curves.
const LEFT = 52, RIGHT = 386; // of the area of a panel, see curves.py
const moving = new Map(); // machines that run, each with what it does a moment later

/** The row at a part of the way, between the two that are next to it. */
function rowAt(rows, share) {
  const at = share * (rows.length - 1), low = Math.floor(at), part = at - low;
  const one = rows[low], next = rows[Math.min(low + 1, rows.length - 1)];
  return one.map((value, k) => value + part * (next[k] - value));
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
  const { speed, run, power } = form.elements;
  let share = slider.value / 360;

  function show() {
    const exact = rowAt(data.exact, share), error = rowAt(data.runs[run.value].errors, share);
    place(ghost, exact);
    place(engine, exact.map((value, k) => value + 10 ** power.value * error[k]));
    const x = LEFT + (RIGHT - LEFT) * share, degrees = data.ends[0] + share * (data.ends[1] - data.ends[0]);
    for (const cursor of cursors) for (const name of ["x1", "x2"]) cursor.setAttribute(name, x);
    const words = `${degrees.toFixed(0)} deg, off by ${offBy(data, exact, error).toPrecision(2)} mm`;
    root.querySelector(".now").textContent = `Crank angle ${words}.`;
    slider.setAttribute("aria-valuetext", words);
  }

  function choose() {
    root.querySelector(".run").textContent = run.selectedOptions[0].textContent;
    root.querySelector(".power").textContent = power.value;
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
