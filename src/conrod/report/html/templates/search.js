// A search in the texts of a site, which the page has with it: each entry is page, address, heading and text.
async function unpack(text) {
  const packed = new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt())]);
  return new Response(packed.stream().pipeThrough(new DecompressionStream("deflate"))).json();
}

const MOST_FOUND = 30, BEFORE = 60, AFTER = 160; // letters of a text around the first word that is found

/** How well an entry fits all words: 0 where it lacks one; a heading counts more than a text. */
function fit([page, , heading, text], words) {
  let sum = 0;
  for (const word of words) {
    const inText = text.toLowerCase().split(word).length - 1;
    const score = 20 * heading.toLowerCase().includes(word) + 8 * page.toLowerCase().includes(word) + Math.min(inText, 5);
    if (!score) return 0;
    sum += score;
  }
  return sum;
}

/** A text around the first of some words, with the word marked. */
function excerpt(text, words) {
  const shown = document.createElement("p"), low = text.toLowerCase();
  const word = words.find((one) => low.includes(one)), at = word ? low.indexOf(word) : 0;
  const begin = Math.max(0, at - BEFORE), end = at + (word ? word.length : 0);
  const marked = document.createElement("mark");
  marked.textContent = text.slice(at, end);
  shown.append((begin ? "\u2026" : "") + text.slice(begin, at), marked, text.slice(end, end + AFTER));
  return shown;
}

for (const root of document.querySelectorAll(".search")) {
  const entries = await unpack(root.querySelector("script").textContent);
  const [input, said, list] = ["input", "output", "ol"].map((tag) => root.querySelector(tag));

  function search() {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = words.length ? entries.map((entry) => [fit(entry, words), entry]).filter(([score]) => score) : [];
    fits.sort((a, b) => b[0] - a[0]);
    said.textContent = words.length ? `${fits.length} places found` : "";
    list.replaceChildren(...fits.slice(0, MOST_FOUND).map(([, [page, address, heading, text]]) => {
      const item = document.createElement("li"), link = document.createElement("a");
      link.href = address;
      link.textContent = heading === page ? page : `${page}: ${heading}`;
      item.append(link, excerpt(text, words));
      return item;
    }));
  }

  input.addEventListener("input", search);
  root.querySelector("form").addEventListener("submit", (event) => event.preventDefault());
  search();
}
