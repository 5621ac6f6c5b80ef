// What the summary says: verdict, what it rests on, warnings, numbers; and the document that the run was made from.
function verdict(run) {
  const status = run.summary.status, usable = ['ok', 'not_judged'].includes(status), root = document.createDocumentFragment();
  const line = make('p', { class: 'verdict' });
  if (status) line.append(make('b', { class: status === 'ok' ? 'good' : usable ? 'warn' : 'bad' }, String(status)));
  line.append(`${run.name}: ${run.kind}` + (run.summary.reason ? '. ' + run.summary.reason : ''));
  root.append(line);
  for (const warning of list(run.summary.warnings)) root.append(make('p', { class: 'verdict' }, make('b', { class: 'warn' }, 'warning'), String(warning.text || warning.id)));
  for (const note of run.notes) root.append(make('p', { class: 'verdict' }, make('b', { class: 'quiet' }, 'note'), note));
  return root;
}
const list = value => Array.isArray(value) ? value.filter(one => one && typeof one === 'object') : [];
const row = (...cells) => make('tr', {}, ...cells);
const cell = (text, number) => make('td', number ? { class: 'number' } : {}, text);
function table(head, rows, caption, right) {
  return make('table', {}, make('caption', { class: 'quiet' }, caption), make('thead', {}, row(...head.map(h => make('th', { scope: 'col', class: right.includes(h) ? 'number' : undefined }, h)))), make('tbody', {}, ...rows));
}
function flat(value, name = '', out = []) {
  if (out.length > 300) return out;
  const errors = name.endsWith('_error') && value && typeof value === 'object' ? Object.entries(value).filter(([, part]) => typeof part === 'number') : [];
  // Of one error a state only the largest.
  if (errors.length > 3) { const [state, most] = errors.reduce((a, b) => Math.abs(b[1]) > Math.abs(a[1]) ? b : a); out.push([`${name}, largest of ${errors.length}`, `${digits(most)} (${state})`]); }
  else if (typeof value === 'number') out.push([name, digits(value)]);
  else if (typeof value === 'string' || typeof value === 'boolean') out.push([name, String(value)]);
  else if (Array.isArray(value)) { if (!value.length) return out; if (value.length <= 8 && value.every(v => typeof v !== 'object')) out.push([name, value.map(v => typeof v === 'number' ? digits(v) : String(v)).join(', ')]); else value.slice(0, 24).forEach((v, i) => flat(v, `${name}[${i}]`, out)); }
  else if (value) for (const [key, part] of Object.entries(value)) if (name || !['judged', 'warnings', 'reason', 'status'].includes(key)) flat(part, name ? `${name}.${key}` : key, out);
  return out;
}
// Numbers of several runs that differ, side by side.
function together(runs) {
  const numbers = runs.map(run => new Map(flat(run.summary)));
  runs.forEach((run, k) => run.summary.status && numbers[k].set('status', String(run.summary.status)));
  const names = [...new Set(['status', ...numbers.flatMap(of => [...of.keys()])])].filter(name => new Set(numbers.map(of => of.get(name))).size > 1);
  if (!names.length) return make('p', {}, 'The summaries of these runs are the same.');
  const rows = names.map(name => row(cell(name), ...numbers.map(of => cell(of.get(name) || '–', (of.get(name) || '').length < 32))));
  const wide = make('div', { class: 'wide', tabindex: '0', role: 'region', 'aria-label': 'Numbers that differ' });
  wide.append(table(['number', ...runs.map(run => run.name)], rows, 'What differs between the summaries of these runs', runs.map(run => run.name)));
  return make('div', {}, make('h2', {}, 'Side by side'), wide);
}
function told(run, several) {
  const root = make('div', {}, make('h2', {}, several ? run.name : 'Numbers')), tables = make('div', { class: 'tables' });
  const judged = list(run.summary.judged);
  if (judged.length) tables.append(table(['judged', 'value', 'limit', 'met'], judged.map(j => row(cell(j.id), cell(`${digits(j.value)} ${j.unit || ''}`, true),
    cell(`${j.allowed === 'at_least' ? 'at least' : 'at most'} ${digits(j.limit)}${j.overridden ? ' (overridden)' : ''}`, true), make('td', { class: j.met ? 'good' : 'bad' }, j.met ? 'met' : 'missed'))), 'What the status rests on', ['value', 'limit']));
  const numbers = flat(run.summary);
  if (numbers.length) tables.append(table(['number', 'value'], numbers.map(([k, v]) => row(cell(k), cell(v, v.length < 32))), 'summary.json', ['value']));
  root.append(tables);
  if (run.settings) { const pre = make('pre', { tabindex: '0', 'aria-label': 'Settings of ' + run.name }); pre.textContent = run.settings; const box = make('details', {}, make('summary', {}, 'Settings of the run'), pre); root.append(box); }
  return root;
}
