// Tables sort by a click on a heading, long ones filter by a word.
const LONG = 8; // rows from which on a table has a filter

/** The value that a cell sorts by: its first number, "< 1e-12" being less than any other; null where it has none. */
function valueOf(cell) {
  const text = cell.textContent.trim(), found = text.match(/^(<?)\s*([-+]?\d[\d.]*(?:e[-+]?\d+)?)/i);
  return found ? parseFloat(found[2]) * (found[1] ? 0.5 : 1) : null;
}

function compare(a, b) {
  const x = valueOf(a), y = valueOf(b);
  if (x !== null && y !== null) return x - y;
  if (x !== null || y !== null) return x !== null ? -1 : 1; // what has no number comes last
  return a.textContent.localeCompare(b.textContent);
}

function sortBy(table, column) {
  const heads = [...table.tHead.rows[0].cells], head = heads[column];
  const down = head.getAttribute("aria-sort") === "ascending";
  heads.forEach((one) => one.removeAttribute("aria-sort"));
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  const rows = [...table.tBodies[0].rows].sort((a, b) => compare(a.cells[column], b.cells[column]));
  table.tBodies[0].append(...(down ? rows.reverse() : rows));
}

function addFilter(table) {
  const label = document.createElement("label"), input = document.createElement("input");
  label.className = "filter";
  label.append("Rows with ", input);
  input.addEventListener("input", () => {
    const wanted = input.value.toLowerCase();
    for (const row of table.tBodies[0].rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
  });
  table.parentElement.before(label);
}

for (const table of document.querySelectorAll("main table")) {
  if (!table.tBodies.length || table.tBodies[0].rows.length < 2) continue;
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    if (!head.textContent.trim()) return;
    const button = document.createElement("button");
    button.append(...head.childNodes);
    button.addEventListener("click", () => sortBy(table, column));
    head.append(button);
  });
  if (table.tBodies[0].rows.length >= LONG) addFilter(table);
}

// What is wider than the screen is scrolled in its box, and says so above.
const hints = new Map();

function tellWidth(box) {
  const wide = box.scrollWidth > box.clientWidth + 1, label = box.previousElementSibling;
  if (wide && !hints.has(box)) {
    const hint = document.createElement("p");
    hint.className = "hint";
    hint.textContent = "\u2194 wider than the screen: scroll it sideways";
    (label && label.matches("label.filter") ? label : box).before(hint);
    hints.set(box, hint);
  }
  if (hints.has(box)) hints.get(box).hidden = !wide;
  if (box.classList.contains("figure")) {
    if (wide) box.tabIndex = 0; // so that the keyboard scrolls it
    else box.removeAttribute("tabindex");
  }
}

const boxes = [...document.querySelectorAll(".scroll, .figure")];
const watcher = new ResizeObserver((seen) => seen.forEach((one) => tellWidth(one.target)));
boxes.forEach((box) => watcher.observe(box));

const tiles = document.querySelector(".tiles");
if (tiles) {
  const button = document.createElement("button"), pictures = [...tiles.querySelectorAll("svg")];
  let still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  const set = () => {
    pictures.forEach((one) => (still ? one.pauseAnimations() : one.unpauseAnimations()));
    button.textContent = still ? "Play" : "Pause";
  };
  button.className = "plain";
  button.addEventListener("click", () => { still = !still; set(); });
  tiles.before(button);
  set();
}
