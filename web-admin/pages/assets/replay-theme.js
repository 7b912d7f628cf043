// The style sheet's colours for canvases, in light and dark.

const NAMES = ['ground', 'surface', 'sunken', 'ink', 'muted', 'line', 'strong-line', 'lead', 'good', 'bad', 'warn',
  'skin', 'fat', 'muscle', 'fascia', 'tissue', 'bone', 'vessel', 'nerve', 'organ', 'part-4'];

export const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif';

// By the number of decimals: to make one takes longer than to write a number.
const formats = [];

// A number with fixed decimals, as the page's language writes it.
export function fixed(value, digits) {
  formats[digits] ??= new Intl.NumberFormat(document.documentElement.lang, {
    minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false, signDisplay: 'negative',
  });
  return formats[digits].format(value).replace('-', '−');
}

export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

export function onThemeChange(react) {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', react);
}

// The colour of a layer's texture, as the drawings on the server choose it.
export function textureColour(theme, texture) {
  const known = { skin: 'skin', fat: 'fat', muscle: 'muscle', fascia: 'fascia', ligament: 'fascia', tendon: 'fascia' };
  return theme[known[texture] || 'tissue'];
}

// "#rgb" or "#rrggbb" as three numbers from 0 to 1.
export function rgb(colour) {
  const hex = colour.replace('#', '');
  const long = hex.length === 3 ? [...hex].map((digit) => digit + digit).join('') : hex;
  return [0, 2, 4].map((at) => parseInt(long.slice(at, at + 2), 16) / 255);
}

// A canvas as sharp as the screen, at the size that the style sheet gives it. True where it changed.
export function fit(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = Math.round(canvas.clientWidth * ratio);
  const height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width === width && canvas.height === height) return false;
  canvas.width = width;
  canvas.height = height;
  return true;
}
