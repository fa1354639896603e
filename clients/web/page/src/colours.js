// Colour maps of equal steps in lightness, by few colours; between them straight lines.
const SEQUENCE = [[84, 84, 168], [52, 112, 158], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
const DIVERGING = [[33, 82, 150], [120, 165, 205], [236, 236, 232], [224, 150, 110], [160, 40, 40]];

function linear(channel) {
  const c = channel / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
}

function table(colours) {
  const out = new Float32Array(256 * 3);
  const css = [];
  for (let i = 0; i < 256; ++i) {
    const at = (i / 255) * (colours.length - 1), k = Math.min(Math.floor(at), colours.length - 2);
    const rgb = colours[k].map((c, d) => c + (at - k) * (colours[k + 1][d] - c));
    css.push(`rgb(${rgb.map(Math.round).join(',')})`);
    rgb.forEach((c, d) => { out[3 * i + d] = linear(c); });
  }
  return { out, css };
}

const MAPS = { sequence: table(SEQUENCE), diverging: table(DIVERGING) };

// Of a range that spans 0, the two-sided one.
export function mapOf(low, high) {
  return low < 0 && high > 0 ? MAPS.diverging : MAPS.sequence;
}

// A colour per vertex from the value of its node.
export function paint(values, nodeOf, low, high, colour) {
  const { out } = mapOf(low, high);
  const scale = 255 / Math.max(high - low, 1e-30);
  for (let i = 0; i < nodeOf.length; ++i) {
    const k = 3 * Math.max(0, Math.min(255, Math.round((values[nodeOf[i]] - low) * scale)));
    colour[3 * i] = out[k];
    colour[3 * i + 1] = out[k + 1];
    colour[3 * i + 2] = out[k + 2];
  }
}

export function drawBar(canvas, low, high) {
  const { css } = mapOf(low, high);
  const context = canvas.getContext('2d');
  for (let x = 0; x < canvas.width; ++x) {
    context.fillStyle = css[Math.round((255 * x) / (canvas.width - 1))];
    context.fillRect(x, 0, 1, canvas.height);
  }
}

const PREFIXES = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
export function engineering(value, unit) {
  const size = Math.abs(value);
  if (!(size > 0)) return `0 ${unit}`;
  const [factor, prefix] = PREFIXES.find(([f]) => size >= 0.9995 * f) ?? PREFIXES.at(-1);
  return `${(value / factor).toPrecision(3)} ${prefix}${unit}`;
}
