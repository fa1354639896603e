// The document's parts by their names, and short notices over the picture.
export const $ = (id) => document.getElementById(id);

let timer = 0;
export function notice(text) {
  $('notice').textContent = text;
  $('notice').hidden = false;
  clearTimeout(timer);
  timer = setTimeout(() => { $('notice').hidden = true; }, 5000);
}

// `many` elements of a tag in a parent, as they were where there are as many.
export function children(parent, tags) {
  if (parent.children.length !== tags.length) parent.replaceChildren(...tags.map((tag) => document.createElement(tag)));
  return parent.children;
}
