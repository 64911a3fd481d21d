// Colours: values to the scale, classes to colours that tell them apart.

// OKLab (Ottosson 2020, 'A perceptual color space for image processing') to sRGB, with less chroma where the
// screen has not as much.
function oklch(light, chroma, turn) {
  for (;; chroma -= 0.004) {
    const a = chroma * Math.cos(turn), b = chroma * Math.sin(turn);
    const l = (light + 0.3963377774 * a + 0.2158037573 * b) ** 3;
    const m = (light - 0.1055613458 * a - 0.0638541728 * b) ** 3;
    const s = (light - 0.0894841775 * a - 1.2914855480 * b) ** 3;
    const rgb = [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
      -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
      -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s];
    if (chroma <= 0 || rgb.every(x => x >= 0 && x <= 1)) {
      return rgb.map(x => Math.round(255 * Math.min(1, Math.max(0,
        x < 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055))));
    }
  }
}
// A scale of even steps in lightness, so that it reads without seeing hues; classes: the colours of Okabe
// and Ito (2008, 'Color universal design') with grey for their black, then the same lighter and darker.
const scale = [], classes = [], okabe = [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167],
  [86, 180, 233], [213, 94, 0], [240, 228, 66], [150, 150, 150]];
for (let i = 0; i < 256; i++) {
  scale.push(oklch(0.5 + 0.43 * i / 255, 0.165, (285 + 175 * i / 255) * Math.PI / 180));
  const step = (i >> 3) % 3, to = step === 1 ? 255 : 0;
  classes.push(okabe[i % 8].map(x => Math.round(step ? 0.6 * x + 0.4 * to : x)));
}
const rgb = c => 'rgb(' + c.join() + ')';
const class_of = x => classes[(x % 256 + 256) % 256];
const at_scale = (a, x) => !(a.high > a.low) ? 0.5 : a.log ? Math.log(Math.max(x, a.low) / a.low)
  / Math.log(a.high / a.low) : (x - a.low) / (a.high - a.low);
const off_scale = (a, t) => a.log ? a.low * (a.high / a.low) ** t : a.low + t * (a.high - a.low);
