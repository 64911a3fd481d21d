// Chart: the histogram of the array that colours show, and its facts.

const svg = (tag, attributes, text) => {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const k in attributes) node.setAttribute(k, attributes[k]);
  if (text !== undefined) node.textContent = text;
  return node;
};
function draw_chart() {
  const a = array, span = a.high - a.low, bin = a.bin, bins = bin.length, chart = $('chart'), wide = 268 / bins;
  const most = Math.max(1, ...bin);
  chart.replaceChildren();
  for (let k = 0; k < bins; k++) {
    const c = a.classes && span < 64 ? class_of(a.low + k) : a.classes ? [128, 128, 128]
      : scale[Math.round(255 * (bins > 1 ? k / (bins - 1) : 0.5))];
    const tall = bin[k] ? Math.max(1, 70 * bin[k] / most) : 0;
    chart.append(svg('rect', { x: k * wide, width: wide - (wide > 3 ? 1 : 0), y: 72 - tall, height: tall,
      fill: rgb(c) }), svg('rect', { x: k * wide, width: wide + 0.3, y: 73, height: 5, fill: rgb(c) }));
  }
  if (!a.classes) [0, 0.5, 1].forEach((t, i) => chart.append(svg('text', { x: 268 * t, y: 90,
    'text-anchor': ['start', 'middle', 'end'][i] }, short(off_scale(a, t), a.log ? 0 : span))));
  const facts = a.classes && a.names.length ? many(bin.filter(x => x).length, 'name')
    : a.classes ? 'classes ' + short(a.low) + ' to ' + short(a.high)
    : 'least ' + short(a.least, a.log ? 0 : span) + ', 1 % below ' + short(a.hundredth, span) + ', mean '
      + short(a.mean, span) + ', largest ' + short(a.largest);
  chart.setAttribute('aria-label', 'Histogram of ' + a.name + ': ' + facts);
  $('summary').textContent = facts;
  $('about').textContent = a.about;
  $('classes').replaceChildren();
  for (let k = 0; a.classes && k < bins && span < 64; k++) {
    const label = document.createElement('span'), mark = document.createElement('i');
    mark.style.background = rgb(class_of(a.low + k));
    label.append(mark, told(a, a.low + k));
    label.title = whole(bin[k]);
    if (bin[k]) $('classes').append(label);
  }
}
function set_array(a) {
  summarise(a);
  array = a;
  $('colour').value = arrays.indexOf(a);
  $('from').value = 0; $('to').value = 1;
  if (gl) upload_values();
  draw_chart();
  change();
}
