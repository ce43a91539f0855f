// Links of a user's model in motion: one time moves the picture and the cursor of its curves.
{
  const LEFT = 52, RIGHT = 386; // of the area of a panel, see panels.py
  const playing = new Map(); // pictures that run, each with what it does a moment later
  const pictures = document.querySelectorAll(".links");

  /** The row at a part of the run, between the two that are next to it; undefined after the end of a shorter one. */
  function rowAt(rows, frames, share) {
    const at = share * (frames - 1), low = Math.floor(at), part = at - low;
    if (at > rows.length - 1) return undefined;
    const one = rows[low], next = rows[Math.min(low + 1, rows.length - 1)];
    return one.map((value, k) => value + part * (next[k] - value));
  }

  function place(group, row) {
    group.style.visibility = row ? "visible" : "hidden";
    if (!row) return;
    for (const shape of group.children) {
      const at = shape.dataset.at.split(",").map(Number);
      if (shape.tagName === "circle") {
        shape.setAttribute("cx", row[2 * at[0]].toFixed(2));
        shape.setAttribute("cy", row[2 * at[0] + 1].toFixed(2));
      } else {
        const points = at.map((k) => `${row[2 * k].toFixed(2)},${row[2 * k + 1].toFixed(2)}`);
        shape.setAttribute("d", `M${points.join(" ")}${at.length > 2 ? "Z" : ""}`);
      }
    }
  }

  for (const root of pictures) {
    const data = JSON.parse(root.querySelector("script").textContent);
    const form = root.querySelector("form"), slider = form.querySelector("input"), play = form.querySelector("button");
    const [ghost, engine] = ["ghost", "engine"].map((name) => root.querySelector(`g.${name}`));
    const labels = [...root.querySelectorAll("text[data-at]")], cursors = [...root.querySelectorAll(".cursor")];
    const lines = [...root.querySelectorAll("path[data-run]")];
    const [left, , width] = root.querySelector("svg").getAttribute("viewBox").split(" ").map(Number);
    const { speed, run, power } = form.elements;
    let share = slider.value / 360;

    function show() {
      const chosen = data.runs[run.value], exact = ghost && rowAt(data.exact, data.exact.length, share);
      const found = rowAt(chosen.rows, ghost ? data.exact.length : chosen.rows.length, share);
      const moved = found && exact ? exact.map((value, k) => value + 10 ** power.value * found[k]) : found;
      if (ghost) place(ghost, exact);
      place(engine, moved);
      for (const label of labels) {
        const k = Number(label.dataset.at), row = moved || exact;
        if (!row) continue;
        const right = row[2 * k] > left + 0.75 * width; // a name there would leave the picture
        label.setAttribute("x", (row[2 * k] + (right ? -12 : 12)).toFixed(1));
        label.setAttribute("y", (row[2 * k + 1] - 12).toFixed(1));
        label.setAttribute("text-anchor", right ? "end" : "start");
      }
      const x = LEFT + (RIGHT - LEFT) * share;
      for (const cursor of cursors) for (const name of ["x1", "x2"]) cursor.setAttribute(name, x);
      const off = chosen.off[Math.round(share * (data.exact.length - 1))];
      const size = off === undefined ? "" : `, off by ${Number(off.toPrecision(2))} mm`;
      const words = `${Number((share * chosen.seconds).toPrecision(3))} s${found ? size : ", after its end"}`;
      root.querySelector(".now").textContent = `At ${words}.`;
      slider.setAttribute("aria-valuetext", words);
    }

    function choose() {
      root.querySelector(".run").textContent = run.selectedOptions[0].textContent;
      if (power) root.querySelector(".power").textContent = power.selectedOptions[0].textContent;
      for (const line of lines) line.classList.toggle("other", line.dataset.run !== run.value);
      show();
    }

    function stop() {
      playing.delete(root);
      play.textContent = "Play";
    }

    function start() {
      play.textContent = "Pause";
      playing.set(root, (seconds) => {
        share = (share + seconds * speed.value) % 1;
        slider.value = Math.round(share * 360);
        show();
      });
    }

    slider.addEventListener("input", () => { stop(); share = slider.value / 360; show(); });
    run.addEventListener("change", choose);
    if (power) power.addEventListener("change", choose);
    play.addEventListener("click", () => (playing.has(root) ? stop() : start()));
    form.hidden = false;
    choose();
    if (root === pictures[0] && !matchMedia("(prefers-reduced-motion: reduce)").matches) start();
  }

  let before = 0;
  requestAnimationFrame(function frame(now) {
    for (const step of playing.values()) step((now - before) / 1000);
    before = now;
    requestAnimationFrame(frame);
  });
}
