// The document's parts by their names, notices and banners over the picture.
export const $ = (id) => document.getElementById(id);

let timer = 0;
export function notice(text) {
  $('notice').textContent = text;
  $('notice').hidden = false;
  clearTimeout(timer);
  timer = setTimeout(() => { $('notice').hidden = true; }, 5000);
}

// In place of a live picture: what is the matter, and what to type, if anything.
export function showBanner(head, text, todo = '') {
  $('banner-head').textContent = head;
  $('banner-text').textContent = text;
  $('banner-todo').textContent = todo;
  $('banner-todo').hidden = !todo;
  $('banner').hidden = false;
}

// A parent's children of these tags, as they were where there are as many.
export function children(parent, tags) {
  if (parent.children.length !== tags.length) parent.replaceChildren(...tags.map((tag) => document.createElement(tag)));
  return parent.children;
}
