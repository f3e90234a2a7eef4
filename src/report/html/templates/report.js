'use strict';
// Draws the charts that the page describes (simgap/report/html/charts.h) with Chart.js, and the table behind each.

const page = JSON.parse(document.getElementById('data').textContent);
page.charts.forEach(spec => spec.series?.forEach(series => {
  if (typeof series.x === 'number') series.x = spec.series[series.x].x;  // written once for lines that share it
}));
const root = document.documentElement;
const colourScheme = matchMedia('(prefers-color-scheme: dark)');
const cssColour = name => getComputedStyle(root).getPropertyValue('--' + name).trim();
const paletteColour = index => cssColour('c' + index % 7);

/** '#rrggbb' with an opacity. */
const translucent = (colour, opacity) => colour + Math.round(255 * opacity).toString(16).padStart(2, '0');

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// ------------------------------------------------------------------------------------------------- numbers

/** Four digits and no more zeros than needed. */
function shortText(value) {
  if (value === null || value === undefined || !isFinite(value)) return '–';
  if (value !== 0 && (Math.abs(value) >= 1e6 || Math.abs(value) < 1e-4)) return value.toExponential(3);
  return String(+value.toPrecision(4));
}

function tableOf(caption, header, rows) {
  const head = element('tr', {}, ...header.map(text => element('th', {scope: 'col'}, text)));
  const body = rows.map(row => element('tr', {}, ...row.map((cell, i) =>
    element(i ? 'td' : 'th', i ? {} : {scope: 'row'}, typeof cell === 'string' ? cell : shortText(cell)))));
  return element('div', {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': caption},
                 element('table', {}, element('thead', {}, head), element('tbody', {}, ...body)));
}

/** Lines that share their x stand side by side, others one below the other. */
function rowsOfLines(spec) {
  const [first, ...others] = spec.series;
  const shared = others.every(s => s.x.length === first.x.length && s.x.every((x, i) => x === first.x[i]));
  if (shared) {
    return [[spec.x.title, ...spec.series.map(s => s.name)], first.x.map((x, i) => [x, ...spec.series.map(s => s.y[i])])];
  }
  return [['', spec.x.title, spec.y.title], spec.series.flatMap(s => s.x.map((x, i) => [s.name, x, s.y[i]]))];
}

const rowsOf = {
  lines: rowsOfLines,
  bars: spec => [['', ...spec.series.map(s => s.name)], spec.labels.map((name, i) => [name, ...spec.series.map(s => s.y[i])])],
  intervals: spec => [['', spec.x.title, 'from', 'to', ''], spec.rows.map(r => [r.name, r.value, r.lower, r.upper, r.group])],
  map: spec => [[spec.y.title + ' \\ ' + spec.x.title, ...columnNames(spec)],
                rowNames(spec).map((name, j) => [name, ...spec.columns.map((_, i) => spec.value[i + j * spec.columns.length])])],
};
const columnNames = spec => spec.column_names.length ? spec.column_names : spec.columns.map(shortText);
const rowNames = spec => spec.row_names.length ? spec.row_names : spec.rows.map(shortText);

// -------------------------------------------------------------------------------------------------- charts

/** Of a logarithmic axis: 1, 2 and 5 of every decade. */
const logLabel = value => [1, 2, 5].includes(Math.round(value / 10 ** Math.floor(Math.log10(value) + 1e-9))) ? shortText(value) : '';

/** Counts have no fractions between them. */
const axisOptions = (axis, values = [0.5]) => ({
  type: axis.log ? 'logarithmic' : 'linear',
  title: {display: axis.title !== '', text: axis.title},
  ticks: axis.log ? {callback: logLabel} : {maxRotation: 0, includeBounds: false, ...(values.every(Number.isInteger) && {precision: 0})},
});

const legend = names => ({display: names.length > 1, labels: {boxWidth: 24, boxHeight: 8}});

const asTooltip = (x, y) => ({
  filter: item => item.dataset.label !== '',
  callbacks: {
    title: items => items.length ? x.title + ': ' + shortText(items[0].parsed.x) : '',
    label: item => ' ' + item.dataset.label + ': ' + shortText(item.parsed.y),
  },
});

function lineDataset(series) {
  const colour = paletteColour(series.colour), dots = series.style === 'points';
  return {
    type: 'scatter', label: series.name, data: series.x.map((x, i) => ({x, y: series.y[i]})),
    showLine: !dots, borderWidth: dots ? 0 : series.faint ? 5 : 2, borderJoinStyle: 'round', borderDash: series.style === 'dashed' ? [6, 4] : [],
    borderColor: series.faint ? translucent(colour, 0.45) : colour,
    backgroundColor: series.faint || dots ? translucent(colour, 0.45) : colour,
    pointRadius: dots ? 2 : series.x.length < 30 ? 2.5 : 0, pointHoverRadius: 4, order: dots || series.faint ? 1 : 0,
  };
}

/** The interval about a line, as a band from its upper edge down to the next dataset, its lower edge. */
function bandDatasets(series) {
  if (!series.half) return [];
  const edge = side => series.x.map((x, i) => ({x, y: series.y[i] === null ? null : series.y[i] + side * series.half[i]}));
  const colour = translucent(paletteColour(series.colour), 0.2);
  return [1, -1].map(side => ({type: 'scatter', label: '', data: edge(side), showLine: true, borderWidth: 0, pointRadius: 0, pointHoverRadius: 0,
                               backgroundColor: colour, fill: side > 0 ? '+1' : false, order: 2}));
}

function linesConfig(spec) {
  const shown = legend(spec.series);
  shown.labels.filter = item => item.text !== '';
  return {
    type: 'scatter', data: {datasets: [...spec.series.map(lineDataset), ...spec.series.flatMap(bandDatasets)]},
    options: {
      bands: spec.bands,
      zoom: spec.zoom,
      interaction: {mode: 'nearest', axis: 'x', intersect: false},
      scales: {x: {...axisOptions(spec.x, spec.series.flatMap(s => s.x)), min: zoomed[spec.zoom]?.[0], max: zoomed[spec.zoom]?.[1]}, y: axisOptions(spec.y)},
      plugins: {legend: shown, tooltip: asTooltip(spec.x, spec.y)},
    },
  };
}

// ---------------------------------------------------------------------------------------------------- zoom

/** The stretch of x that all charts of a group show; none: all of it. */
const zoomed = {};

function wholeRange(spec) {
  const all = spec.series.flatMap(s => s.x).filter(x => x !== null);
  return [all.reduce((a, b) => Math.min(a, b), Infinity), all.reduce((a, b) => Math.max(a, b), -Infinity)];
}

/** All charts of the group show that stretch; with none, everything. */
function zoomTo(group, range) {
  if (range) zoomed[group] = range; else delete zoomed[group];
  charts.filter(chart => chart.config.options.zoom === group).forEach(chart => {
    Object.assign(chart.options.scales.x, {min: range?.[0], max: range?.[1]});
    chart.update('none');
  });
  document.querySelectorAll(`.zoom[data-group="${group}"] button`).forEach(button => { button.disabled = !range; });
}

/** The wheel comes nearer to the pointer once the chart has been clicked; dragging chooses a stretch; a double click or the button shows all. */
function offerZoom(figure, spec) {
  const canvas = figure.querySelector('canvas'), bar = figure.querySelector('.zoom');
  const button = element('button', {type: 'button', disabled: ''}, 'Show all');
  const [low, high] = wholeRange(spec);
  bar.dataset.group = spec.zoom;
  bar.append('Drag to look closer; click, then use the wheel. ', button);
  canvas.tabIndex = 0;
  const chart = () => charts.find(c => c.canvas === canvas);
  const place = event => chart().scales.x.getValueForPixel(event.clientX - canvas.getBoundingClientRect().left);
  let begin = null;
  button.addEventListener('click', () => zoomTo(spec.zoom, null));
  canvas.addEventListener('dblclick', () => zoomTo(spec.zoom, null));
  canvas.addEventListener('pointerdown', event => { canvas.focus(); begin = place(event); });
  canvas.addEventListener('pointermove', event => {
    if (begin === null) return;
    chart().config.options.chosen = [begin, place(event)];
    chart().draw();
  });
  canvas.addEventListener('pointerup', event => {
    if (begin === null) return;
    const range = [begin, place(event)].sort((a, b) => a - b).map(x => Math.min(Math.max(x, low), high));
    begin = null;
    chart().config.options.chosen = null;
    if (range[1] - range[0] > 0.005 * (chart().scales.x.max - chart().scales.x.min)) zoomTo(spec.zoom, range); else chart().draw();
  });
  canvas.addEventListener('pointerleave', () => { begin = null; chart().config.options.chosen = null; });
  canvas.addEventListener('wheel', event => {
    if (document.activeElement !== canvas) return;  // the wheel scrolls the page until the chart has the focus
    event.preventDefault();
    const {min, max} = chart().scales.x, about = place(event), factor = Math.exp(0.002 * event.deltaY);
    const range = [Math.max(about - (about - min) * factor, low), Math.min(about + (max - about) * factor, high)];
    zoomTo(spec.zoom, range[0] <= low && range[1] >= high ? null : range);
  }, {passive: false});
}

/** Shades the stretch that is being chosen. */
const choicePainter = {
  id: 'choice',
  afterDatasetsDraw(chart) {
    const range = chart.config.options.chosen;
    if (!range) return;
    const {ctx, chartArea: {top, bottom}, scales: {x}} = chart, [from, to] = range.map(value => x.getPixelForValue(value));
    ctx.fillStyle = translucent(cssColour('c0'), 0.2);
    ctx.fillRect(from, top, to - from, bottom - top);
  },
};

/** "Before" is hollow and pale, "after" full: told apart without colour, too. */
function barsConfig(spec) {
  const datasets = spec.series.map(s => {
    const colour = paletteColour(s.colour);
    return {label: s.name, data: s.y, backgroundColor: s.faint ? translucent(colour, 0.25) : colour,
            borderColor: colour, borderWidth: s.faint ? 1 : 0};
  });
  return {
    type: 'bar', data: {labels: spec.labels, datasets},
    options: {
      interaction: {mode: 'index', intersect: false},
      onClick: (event, items) => items.length && spec.poses && showPose(`${spec.poses} pose ${spec.labels[items[0].index]}`),
      scales: {x: {grid: {display: false}, title: {display: Boolean(spec.x), text: spec.x?.title}}, y: axisOptions(spec.y)},
      plugins: {legend: legend(spec.series)},
    },
  };
}

/** A bar of a pose shows that pose in the view in three dimensions. */
function showPose(name) {
  for (const view of typeof views === 'undefined' ? [] : views) view.showPose(name);
}

/** On narrow screens a parameter's name keeps what tells it apart: the muscle and the end of its path. */
const rowLabel = (name, width) => width >= 520 ? name :
  name.replace(/^(muscles|joints|bodies)\./, '').replace(/attachments\.(\d+)\.point_m\./, 'at $1 ').replace('shock_cord.', '').replace(/_(m|rad|N_m|Ns_m|kg)$/, '');

/** A dot on its interval, one row each; rows of a group share a colour. */
function intervalsConfig(spec) {
  const groups = [...new Map(spec.rows.map(r => [r.group, r.colour]))].sort((a, b) => a[1] - b[1]);
  const datasets = groups.flatMap(([group, index]) => {
    const colour = paletteColour(index), own = r => r.group === group;
    return [
      {type: 'line', label: group, data: spec.rows.map(r => own(r) ? r.value : null), showLine: false, borderColor: colour,
       backgroundColor: colour, pointRadius: 5, pointStyle: spec.rows.map(r => r.marked ? 'triangle' : 'circle')},
      {type: 'bar', label: '', data: spec.rows.map(r => own(r) && r.lower !== null && r.upper !== null ? [r.lower, r.upper] : null),
       backgroundColor: translucent(colour, 0.4), barThickness: 5, grouped: false},
    ];
  });
  const label = item => {
    const row = spec.rows[item.dataIndex];
    return ' ' + shortText(row.value) + (row.lower === null ? '' : ' (' + shortText(row.lower) + ' to ' + shortText(row.upper) + ')');
  };
  return {
    type: 'bar', data: {labels: spec.rows.map(r => r.name), datasets},
    options: {
      indexAxis: 'y',
      scales: {x: axisOptions(spec.x), y: {offset: true, ticks: {autoSkip: false, callback(value) { return rowLabel(this.getLabelForValue(value), this.chart.width); }}, grid: {display: false}}},
      plugins: {
        legend: {...legend(groups), labels: {usePointStyle: true, filter: item => item.text !== ''}},
        tooltip: {filter: item => item.dataset.type === 'line', callbacks: {label}},
      },
    },
  };
}

// --------------------------------------------------------------------------------------------------- maps

const mixed = (a, b, t) => '#' + [1, 3, 5].map(i => {
  const from = parseInt(a.slice(i, i + 2), 16), to = parseInt(b.slice(i, i + 2), 16);
  return Math.round(from + t * (to - from)).toString(16).padStart(2, '0');
}).join('');

/** The colour of a place on a scale: 0 to 1 from dark to pale, or -1 to 1 about the middle colour. */
function scaleColour(t, diverging) {
  if (diverging) return mixed(cssColour('zero'), cssColour(t < 0 ? 'high' : 'low'), Math.min(Math.abs(t), 1));
  const stops = ['#440154', '#3b528b', '#21918c', '#5ec962', '#fde725'];  // viridis (van der Walt & Smith 2015)
  const place = Math.min(Math.max(t, 0), 1) * 4, stop = Math.min(Math.floor(place), 3);
  return mixed(stops[stop], stops[stop + 1], place - stop);
}

/** Where values lie on the colour scale of a map, and the ends of that scale. */
function mapScale(spec) {
  const scaled = value => spec.log ? Math.log10(Math.max(value, 1e-300)) : value;
  const values = spec.value.filter(v => v !== null).map(scaled);
  const low = Math.min(...values), high = Math.max(...values);
  const range = spec.range || Math.max(Math.abs(low), Math.abs(high), 1e-300);
  const shown = value => shortText(spec.log ? 10 ** value : value);
  return {
    place: value => spec.diverging ? scaled(value) / range : high > low ? (scaled(value) - low) / (high - low) : 1,
    ends: spec.diverging ? [shown(-range), shown(range)] : [shown(low), shown(high)],
  };
}

const step = centres => centres.length < 2 ? 1 : Math.min(...centres.slice(1).map((c, i) => c - centres[i]));

/** Fills the cells below the datasets. */
const cellPainter = {
  id: 'cells',
  beforeDatasetsDraw(chart) {
    const spec = chart.config.options.map;
    if (!spec) return;
    const {ctx, scales: {x, y}} = chart, scale = mapScale(spec);
    const width = step(spec.columns) / 2, height = step(spec.rows) / 2;
    spec.value.forEach((value, i) => {
      if (value === null) return;
      const cx = spec.columns[i % spec.columns.length], cy = spec.rows[Math.floor(i / spec.columns.length)];
      const left = x.getPixelForValue(cx - width), right = x.getPixelForValue(cx + width);
      const top = y.getPixelForValue(cy + height), bottom = y.getPixelForValue(cy - height);
      const place = scale.place(value);
      ctx.fillStyle = scaleColour(place, spec.diverging);
      ctx.fillRect(left, top, right - left + 0.5, bottom - top + 0.5);
      if (!spec.written) return;
      ctx.fillStyle = spec.diverging ? (Math.abs(place) > 0.6 ? cssColour('page') : cssColour('text')) : place > 0.6 ? '#000' : '#fff';
      ctx.textAlign = 'center';
      ctx.textBaseline = 'middle';
      ctx.font = '11px system-ui, sans-serif';
      ctx.fillText(+value.toPrecision(2), (left + right) / 2, (top + bottom) / 2);
    });
  },
};

/** Shades stretches of the x axis below the lines. */
const bandPainter = {
  id: 'bands',
  beforeDatasetsDraw(chart) {
    const {ctx, chartArea: {left, right, top, bottom}, scales: {x}} = chart;
    ctx.fillStyle = translucent(cssColour('c6'), 0.2);
    for (const [from, to] of chart.config.options.bands || []) {
      const begin = Math.max(x.getPixelForValue(from), left), end = Math.min(x.getPixelForValue(to), right);
      ctx.fillRect(begin, top, Math.max(end - begin, 1), bottom - top);
    }
  },
};

function mapAxis(axis, centres, names, outlines) {
  const half = step(centres) / 2;
  const options = {...axisOptions(axis), min: Math.min(...centres, ...outlines) - half, max: Math.max(...centres, ...outlines) + half, grid: {display: false}};
  if (!names.length) return options;
  options.afterBuildTicks = scale => { scale.ticks = centres.map(value => ({value})); };
  options.ticks = {autoSkip: false, maxRotation: 60, callback: value => names[centres.indexOf(value)]};
  return options;
}

function mapConfig(spec) {
  const cells = spec.value.map((value, i) => ({x: spec.columns[i % spec.columns.length],
                                               y: spec.rows[Math.floor(i / spec.columns.length)], value})).filter(c => c.value !== null);
  const outlines = spec.series.map(s => ({...lineDataset(s), borderColor: cssColour('text'), pointRadius: 0}));
  const name = (names, value, centres) => names.length ? names[centres.indexOf(value)] : shortText(value);
  const label = item => {
    const cell = item.raw;
    if (cell.value === undefined) return item.dataset.label;
    return ` ${name(spec.column_names, cell.x, spec.columns)}, ${name(spec.row_names, cell.y, spec.rows)}: ${shortText(cell.value)} ${spec.unit}`;
  };
  return {
    type: 'scatter',
    data: {datasets: [...outlines, {label: spec.unit, data: cells, pointRadius: 0, pointHitRadius: 12, pointHoverRadius: 0}]},
    options: {
      map: spec,
      scales: {x: mapAxis(spec.x, spec.columns, spec.column_names, spec.series.flatMap(s => s.x)),
               y: mapAxis(spec.y, spec.rows, spec.row_names, spec.series.flatMap(s => s.y))},
      plugins: {legend: {display: outlines.length > 0, labels: {filter: item => item.datasetIndex < outlines.length}},
                tooltip: {callbacks: {label}}},
    },
  };
}

/** The colour scale in words and as a bar. */
function scaleBar(spec) {
  const {ends} = mapScale(spec), places = [0, 0.25, 0.5, 0.75, 1];
  const colours = places.map(t => scaleColour(spec.diverging ? 2 * t - 1 : t, spec.diverging));
  return element('div', {class: 'scale'}, ends[0], element('span', {class: 'bar', style: `background: linear-gradient(to right, ${colours})`}),
                 ends[1] + ' ' + spec.unit);
}

// --------------------------------------------------------------------------------------------------- page

const configs = {lines: linesConfig, bars: barsConfig, intervals: intervalsConfig, map: mapConfig};
const charts = [];

function drawCharts() {
  charts.splice(0).forEach(chart => chart.destroy());
  Chart.defaults.color = cssColour('soft');
  Chart.defaults.borderColor = cssColour('line');
  Chart.defaults.animation = false;
  Chart.defaults.maintainAspectRatio = false;
  document.querySelectorAll('figure.chart').forEach(figure => {
    const spec = page.charts[figure.dataset.chart], plot = figure.querySelector('.plot');
    if (spec.kind === 'intervals') plot.style.height = `${1.35 * spec.rows.length + 6}rem`;
    figure.querySelector('.scale')?.remove();
    if (spec.kind === 'map') plot.after(scaleBar(spec));
    charts.push(new Chart(plot.querySelector('canvas'), {...configs[spec.kind](spec), plugins: [cellPainter, bandPainter, choicePainter]}));
  });
}

/** The table behind a figure is made when somebody opens it. */
function offerNumbers(figure, caption, rows) {
  const details = figure.querySelector('.numbers');
  details.addEventListener('toggle', () => {
    details.querySelector('.scroll')?.remove();
    if (details.open) details.append(tableOf(caption, ...rows()));
  });
}

document.querySelectorAll('figure.chart').forEach(figure => {
  const spec = page.charts[figure.dataset.chart];
  if (spec.zoom) offerZoom(figure, spec);
  offerNumbers(figure, figure.querySelector('figcaption').textContent, () => rowsOf[spec.kind](spec));
});

document.querySelector('.copy')?.addEventListener('click', event => {
  const code = event.target.previousElementSibling;
  getSelection().selectAllChildren(code);
  if (!navigator.clipboard) document.execCommand('copy');
  (navigator.clipboard?.writeText(code.textContent) ?? Promise.resolve()).then(() => { event.target.textContent = 'Copied'; }, () => document.execCommand('copy'));
});

const redrawers = [drawCharts];
const redraw = () => redrawers.forEach(draw => draw());
colourScheme.addEventListener('change', redraw);
addEventListener('beforeprint', () => {
  document.querySelectorAll('details.section').forEach(section => { section.open = true; });
  root.dataset.paper = '';
  redraw();
});
addEventListener('afterprint', () => { delete root.dataset.paper; redraw(); });
drawCharts();
