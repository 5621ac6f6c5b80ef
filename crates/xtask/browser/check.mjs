// The pages of runs in headless Chromium, with real mouse, touch and keyboard: `node check.mjs FOLDER`, which holds the run folders
// `turn` and `minute`, the page small.html without wake, and hostile.html. Pictures of every page are left in FOLDER/pictures, and held
// against the summaries in reference.json, which WRITE_REFERENCES=1 writes anew. WINGBEAT names the program.
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { createRequire } from 'node:module';
import { execFileSync, spawn } from 'node:child_process';
import net from 'node:net';

const folder = path.resolve(process.argv[2]), references = path.join(import.meta.dirname, 'reference.json');
const require = createRequire(path.join(folder, 'node_modules/'));
const puppeteer = require('puppeteer-core');
const axe = fs.readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');
const pictures = path.join(folder, 'pictures');
fs.mkdirSync(pictures, { recursive: true });
let passed = 0, failed = 0;
const judge = (name, value, holds, limit) => {
  holds ? passed++ : failed++;
  console.log(`${name.padEnd(52)} ${String(value).padStart(12)}  ${limit}${holds ? '' : '  FAILED'}`);
};
const most = (name, value, limit, unit = '') => judge(name, +value.toPrecision(4), value <= limit, `at most ${limit} ${unit}`);
const least = (name, value, limit, unit = '') => judge(name, +value.toPrecision(4), value >= limit, `at least ${limit} ${unit}`);
const holds = (name, value, why = '') => judge(name, !!value, !!value, why);
const wait = ms => new Promise(done => setTimeout(done, ms));

const browser = await puppeteer.launch({
  executablePath: process.env.CHROMIUM || '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
const requests = [];
async function open(file, { hash = 'still', width = 1400, height = 800, touch = false, media = {}, type } = {}) {
  const page = await browser.newPage();
  await page.bringToFront();
  page.on('pageerror', error => { console.log('page error:', file, error.message); failed++; });
  const client = await page.createCDPSession();
  await client.send('Network.enable');
  client.on('Network.requestWillBeSent', event => requests.push(event.request.url));
  await page.setViewport({ width, height, hasTouch: touch });
  const features = Object.entries(media).map(([name, value]) => ({ name, value }));
  const emulate = async () => { if (features.length) await page.emulateMediaFeatures(features); if (type) await page.emulateMediaType(type); };
  await emulate();
  await page.goto(pathToFileURL(path.join(folder, file)).href + '#' + hash);
  await page.waitForFunction('window.wingbeat && (window.wingbeat.ready || document.querySelector("main.flat"))', { timeout: 120000 });
  // A session of its own may forget the medium on the way to the page.
  await emulate();
  await wait(400);
  return { page, client };
}
const of = (page, expression) => page.evaluate(expression);
const known = fs.existsSync(references) ? JSON.parse(fs.readFileSync(references)) : {}, seen = {};
// A picture is left in its file. One of what is on the screen is also held against what was stored of it: means of 32 by 18 areas.
async function picture(page, name, fullPage = false) {
  const file = path.join(pictures, name + '.png');
  // As it is once it rests.
  await page.evaluate('wingbeat.sharpen()');
  const bytes = await page.screenshot({ path: file, fullPage });
  if (fullPage) return;
  seen[name] = await page.evaluate(async letters => {
    const bytes = Uint8Array.from(atob(letters), c => c.charCodeAt(0)), size = { resizeWidth: 32, resizeHeight: 18, resizeQuality: 'high' };
    const c = document.createElement('canvas'), x = c.getContext('2d', { willReadFrequently: true });
    c.width = 32; c.height = 18; x.drawImage(await createImageBitmap(new Blob([bytes]), size), 0, 0);
    const data = x.getImageData(0, 0, 32, 18).data;
    return btoa(String.fromCharCode(...data.filter((_, i) => i % 4 < 3)));
  }, Buffer.from(bytes).toString('base64'));
  const [now, then] = [seen[name], known[name] || ''].map(letters => [...Buffer.from(letters, 'base64')]);
  if (process.env.WRITE_REFERENCES) return;
  holds(`${name}: there is a reference`, now.length === then.length);
  if (now.length !== then.length) return;
  const apart = now.map((v, i) => Math.abs(v - then[i]));
  most(`${name}: mean difference from the reference, of 255`, apart.reduce((a, b) => a + b, 0) / apart.length, 3);
  most(`${name}: largest difference of an area`, Math.max(...apart), 50);
}
async function rate(page, seconds = 4) {
  await of(page, 'wingbeat.play(true)');
  await wait(1500);
  const frames = await of(page, 'wingbeat.frames');
  await wait(1000 * seconds);
  const drawn = (await of(page, 'wingbeat.frames')) - frames;
  await of(page, 'wingbeat.play(false)');
  return drawn / seconds;
}
// Private memory of the process that draws the page, MB.
async function memory(page) {
  const pids = fs.readdirSync('/proc').filter(name => /^\d+$/.test(name));
  const mine = browser.process().pid;
  const parents = Object.fromEntries(pids.map(pid => { try { return [pid, fs.readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ')[1]]; } catch { return [pid, '0']; } }));
  const ours = pid => { for (let p = pid; p && p !== '0'; p = parents[p]) if (+p === mine) return true; return false; };
  let largest = 0;
  for (const pid of pids.filter(ours)) try {
    if (!fs.readFileSync(`/proc/${pid}/cmdline`, 'utf8').includes('--type=renderer')) continue;
    const roll = fs.readFileSync(`/proc/${pid}/smaps_rollup`, 'utf8');
    const of = name => +new RegExp(name + ':\\s+(\\d+)').exec(roll)[1];
    largest = Math.max(largest, (of('Private_Clean') + of('Private_Dirty')) / 1024);
  } catch { /* it has ended */ }
  return largest;
}

// What the page costs of a run: least processor times of runs in turns with it and without.
{
  const root = path.resolve(import.meta.dirname, '../../..'), out = path.join(folder, 'cost');
  const cost = more => {
    const run = ['fly', 'scenarios/banking_turn.toml', '--quiet', '--force', '--out', out, ...more];
    const said = execFileSync('sh', ['-c', '"$@" > /dev/null 2>&1; times', 'sh', process.env.WINGBEAT, ...run], { cwd: root, encoding: 'utf8' });
    return said.trim().split('\n')[1].split(' ').reduce((sum, word) => { const [, m, s] = /(\d+)m([\d.]+)s/.exec(word); return sum + 60 * m + +s; }, 0);
  };
  const least = [Infinity, Infinity];
  for (let turn = 0; turn < 7; turn++) [['--no-report'], []].forEach((more, k) => least[k] = Math.min(least[k], cost(more)));
  console.log(`  a flight of 5 s takes ${least[0].toFixed(2)} s of processor time, with its page ${least[1].toFixed(2)} s`);
  most('cost of the page, share of the processor time of the run', least[1] / least[0] - 1, 0.05);
}

const size = file => fs.statSync(path.join(folder, file)).size / 1000;
most('size with wake and forces of strips', size('turn/report.html'), 500, 'kB');
most('size without wake', size('small.html'), 200, 'kB');

{ // Light, keys, mouse.
  const { page } = await open('turn/report.html');
  await page.waitForFunction(`performance.getEntriesByName('first-contentful-paint').length`, { timeout: 20000 });
  const paint = await of(page, `performance.getEntriesByName('first-contentful-paint')[0].startTime`);
  most('first paint', paint, 1000, 'ms');
  judge('drawn with', await of(page, 'wingbeat.renderer'), (await of(page, 'wingbeat.renderer')) === 'WebGL 2', 'WebGL 2');
  const t = () => of(page, 'wingbeat.state.t');
  await page.keyboard.press('End'); holds('End goes to the end', Math.abs(await t() - 5) < 1e-6);
  await page.keyboard.press('Home'); holds('Home goes to the start', (await t()) === 0);
  await page.keyboard.press('ArrowRight'); holds('an arrow goes a frame', Math.abs(await t() - 0.005) < 1e-4);
  await page.keyboard.down('Shift'); await page.keyboard.press('ArrowRight'); await page.keyboard.up('Shift');
  holds('with Shift it goes ten', Math.abs(await t() - 0.055) < 1e-3);
  await page.keyboard.press('Space'); await wait(700); holds('Space plays', await of(page, 'wingbeat.state.playing') && await t() > 0.2);
  await page.keyboard.press('Space'); holds('and pauses', !(await of(page, 'wingbeat.state.playing')));
  await page.keyboard.press('-'); holds('minus slows down', (await of(page, 'wingbeat.state.speed')) === 0.5);
  for (const [key, mode] of [['2', 'follow'], ['3', 'whole'], ['4', 'side'], ['5', 'top'], ['1', 'chase']]) { await page.keyboard.press(key); judge(`key ${key} chooses a camera`, await of(page, 'wingbeat.view.mode'), (await of(page, 'wingbeat.view.mode')) === mode, mode); }
  const box = await (await page.$('#space')).boundingBox(), [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const before = await of(page, 'wingbeat.view.azimuth');
  await page.mouse.move(x, y); await page.mouse.down(); await page.mouse.move(x + 80, y + 20, { steps: 4 }); await page.mouse.up();
  holds('a drag turns the view', Math.abs(await of(page, 'wingbeat.view.azimuth') - before) > 0.3);
  await page.mouse.wheel({ deltaY: -300 }); holds('the wheel zooms', (await of(page, 'wingbeat.view.zoom')) < 0.8);
  await page.keyboard.press('f'); holds('F fits', (await of(page, 'wingbeat.view.zoom')) === 1);
  const plot = await (await page.$('.panel svg')).boundingBox();
  await page.mouse.click(plot.x + 46 + 0.6 * (plot.width - 52), plot.y + 40);
  holds('a click into a plot goes to its time', Math.abs(await t() - 3) < 0.05, '3 s');
  await page.click('[data-name="strips"] input'); await page.keyboard.press('w');
  holds('W hides the wake', !(await of(page, 'shown.wake')));
  await page.keyboard.press('w');
  await page.evaluate('wingbeat.seek(2.6); wingbeat.frame()');
  await picture(page, 'light-strips');
  await page.click('[data-name="strips"] input');
  await picture(page, 'light'); await picture(page, 'light-whole-page', true);
  for (const [name, key] of [['whole', '3'], ['side', '4'], ['above', '5']]) { await page.keyboard.press(key); await wait(100); await picture(page, 'light-' + name); }
  await page.keyboard.press('1');
  const smallest = await of(page, `Math.min(...[...document.querySelectorAll('body *')].filter(e => [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim()) && !/SCRIPT|STYLE|NOSCRIPT/.test(e.tagName)).map(e => parseFloat(getComputedStyle(e).fontSize)))`);
  least('smallest letters', smallest, 11, 'px');
  least('frames a second, software GL at 1400 x 800', await rate(page), 30);
  await page.close();
}
{ // The same frame, by both ways to draw.
  const shots = [];
  for (const hash of ['t=2.6', 't=2.6,2d']) {
    const { page } = await open('turn/report.html', { hash });
    shots.push(await of(page, `wingbeat.frame(), document.getElementById('space').toDataURL()`));
    if (hash.includes('2d')) { judge('drawn with', await of(page, 'wingbeat.renderer'), (await of(page, 'wingbeat.renderer')) === 'canvas', 'canvas'); await picture(page, 'flat'); least('frames a second, canvas at 1400 x 800', await rate(page), 15); }
    await page.close();
  }
  const { page } = await open('turn/report.html');
  const apart = await page.evaluate(async urls => {
    const pixels = async url => { const image = new Image(); image.src = url; await image.decode(); const c = document.createElement('canvas'); c.width = 400; c.height = 240; const x = c.getContext('2d'); x.drawImage(image, 0, 0, 400, 240); return x.getImageData(0, 0, 400, 240).data; };
    const [a, b] = [await pixels(urls[0]), await pixels(urls[1])];
    let sum = 0; for (let i = 0; i < a.length; i++) sum += Math.abs(a[i] - b[i]);
    return sum / a.length;
  }, shots);
  most('mean difference of WebGL 2 and canvas, of 255', apart, 8);
  await page.close();
}
for (const scheme of ['light', 'dark']) {
  const { page } = await open('turn/report.html', { hash: 't=2.6', media: { 'prefers-color-scheme': scheme } });
  if (scheme === 'dark') { await picture(page, 'dark'); await picture(page, 'dark-whole-page', true); }
  await page.evaluate(() => document.querySelectorAll('details').forEach(details => details.open = true));
  await page.evaluate(axe);
  const found = (await page.evaluate('axe.run()')).violations;
  for (const one of found) console.log(`  axe, ${scheme}: ${one.impact} ${one.id}: ${one.nodes.length} of ${one.nodes[0].html.slice(0, 120)}`);
  most(`findings of axe-core that are serious, ${scheme}`, found.filter(one => ['serious', 'critical'].includes(one.impact)).length, 0);
  await page.close();
}
{ // Narrow, touch.
  const { page, client } = await open('turn/report.html', { hash: 't=2.6', width: 400, height: 860, touch: true });
  most('width of the page at 400 px', await of(page, 'document.documentElement.scrollWidth'), 400, 'px');
  await picture(page, 'narrow'); await picture(page, 'narrow-whole-page', true);
  const box = await (await page.$('#space')).boundingBox(), [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const touch = (type, ...points) => client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const azimuth = await of(page, 'wingbeat.view.azimuth');
  await touch('touchStart', [x, y]); await touch('touchMove', [x + 60, y]); await touch('touchEnd');
  holds('a finger turns the view', Math.abs(await of(page, 'wingbeat.view.azimuth') - azimuth) > 0.2);
  const zoom = await of(page, 'wingbeat.view.zoom');
  await touch('touchStart', [x - 30, y], [x + 30, y]); await touch('touchMove', [x - 70, y], [x + 70, y]); await touch('touchEnd');
  holds('two fingers zoom', (await of(page, 'wingbeat.view.zoom')) < 0.8 * zoom);
  const plot = await page.$('.panel svg');
  await plot.scrollIntoView(); await plot.tap();
  holds('a tap into a plot goes to its time', Math.abs(await of(page, 'wingbeat.state.t') - 2.6) > 0.01);
  await page.close();
}
{ // Print, reduced motion.
  const { page } = await open('turn/report.html', { hash: 't=2.6', width: 794, height: 1123, type: 'print' });
  await of(page, `dispatchEvent(new Event('beforeprint'))`);
  holds('paper has no buttons', await of(page, `getComputedStyle(document.getElementById('controls')).display`) === 'none');
  await picture(page, 'print', true);
  await page.pdf({ path: path.join(pictures, 'print.pdf'), format: 'A4', printBackground: true });
  least('printed page', fs.statSync(path.join(pictures, 'print.pdf')).size / 1000, 30, 'kB');
  await page.close();
  const still = await open('turn/report.html', { hash: '', media: { 'prefers-reduced-motion': 'reduce' } });
  holds('nothing moves by itself where motion is to be reduced', !(await of(still.page, 'wingbeat.state.playing')));
  await still.page.close();
  const plays = await open('turn/report.html', { hash: '' });
  holds('else it plays', await of(plays.page, 'wingbeat.state.playing'));
  await plays.page.close();
}
{ // A minute of flight.
  const bare = await browser.newPage();
  await bare.goto('about:blank');
  const empty = await memory(bare);
  const { page } = await open('minute/report.html');
  await rate(page, 3);
  const used = await memory(page), heap = await of(page, 'performance.memory.usedJSHeapSize / 1e6');
  console.log(`  an empty page ${empty.toFixed(0)} MB, its heap of JavaScript ${heap.toFixed(0)} MB`);
  most('memory with a minute of flight', used, 200, 'MB');
  await bare.close(); await page.close();
}
for (const file of fs.readdirSync(folder).filter(name => name.startsWith('hostile')).sort()) {
  const { page } = await open(file);
  holds(`${file}: nothing of its texts runs`, (await of(page, 'window.pwned')) === undefined && !(await page.$('img')));
  holds(`${file}: its title is shown`, (await page.title()).length > 0 && (await of(page, `document.querySelector('h1').textContent`)) === (await page.title()));
  await picture(page, file.replace('.html', ''));
  await page.close();
}
const KINDS = { light: {}, dark: { media: { 'prefers-color-scheme': 'dark' } }, narrow: { width: 400, height: 860 }, print: { width: 794, height: 1123, type: 'print' } };
for (const name of fs.readdirSync(folder).filter(name => fs.existsSync(path.join(folder, name, 'report.html')) && !['turn', 'minute', 'live'].includes(name)).sort()) {
  for (const [look, options] of Object.entries(KINDS)) {
    const { page } = await open(`${name}/report.html`, { hash: 'still', ...options });
    if (look === 'narrow') most(`${name}: width at 400 px`, await of(page, 'document.documentElement.scrollWidth'), 400, 'px');
    if (look === 'print') await of(page, `dispatchEvent(new Event('beforeprint'))`);
    await picture(page, `kind-${name}-${look}`, look === 'print' || look === 'narrow');
    if (look === 'light') {
      await picture(page, `kind-${name}-whole-page`, true);
      await page.evaluate(axe);
      const found = (await page.evaluate('axe.run()')).violations.filter(one => ['serious', 'critical'].includes(one.impact));
      for (const one of found) console.log(`  axe, ${name}: ${one.id}: ${one.nodes[0].html.slice(0, 120)}`);
      most(`${name}: serious findings of axe-core`, found.length, 0);
    }
    await page.close();
  }
}
// A computation on its page while it goes on.
const started = arguments_ => {
  const child = spawn(process.env.WINGBEAT, arguments_, { stdio: ['ignore', 'ignore', 'pipe'] });
  let said = '';
  const address = new Promise((found, lost) => {
    child.stderr.on('data', text => { said += text; const at = /watch: (\S+)/.exec(said); if (at) found(at[1]); });
    child.on('exit', () => lost(new Error(said)));
  });
  const ended = new Promise(done => child.on('exit', code => done(code)));
  return { address, ended, stop: () => child.kill('SIGINT') };
};
async function live(name, arguments_, look) {
  const run = started([...arguments_, '--watch', '--quiet', '--force', '--out', path.join(folder, 'live')]), address = await run.address;
  const page = await browser.newPage(), asked = [];
  page.on('pageerror', error => { console.log('page error:', name, error.message); failed++; });
  page.on('request', request => asked.push(request.url()));
  await page.setViewport({ width: 1400, height: 800 });
  await page.goto(address);
  await page.waitForFunction('window.wingbeat && window.wingbeat.ready', { timeout: 30000 });
  await look(page, address, run);
  holds(`live, ${name}: only its own address is asked`, asked.every(url => url.startsWith(address)));
  await page.close();
  return run;
}
const said = page => of(page, `document.querySelector('[role=status]').dataset.word`);
const rows = page => of(page, 'Math.max(0, ...wingbeat.runs.map(run => run.axis.values.length))');
const SCENARIO = 'scenarios/banking_turn.toml', LASTS = 40, LONG = ['--set', `flight.duration_s=${LASTS}`];
{
  const run = await live('a flight', ['fly', SCENARIO, ...LONG], async (page, address, run) => {
    await page.waitForFunction('wingbeat.version > 0 && wingbeat.runs[0].motion && wingbeat.runs[0].axis.values.length > 20', { timeout: 60000 });
    const first = await rows(page), version = await of(page, 'wingbeat.version');
    await page.waitForFunction(`wingbeat.version > ${version + 1}`, { timeout: 60000 });
    const second = await rows(page);
    judge('live: the page follows', second, second > first, `more than ${first} rows`);
    holds('live: it stands at the end', (await of(page, 'wingbeat.state.t')) === (await of(page, 'wingbeat.high')));
    await page.keyboard.press('Home'); await page.keyboard.press('4');
    const then = await of(page, 'wingbeat.version');
    await page.waitForFunction(`wingbeat.version > ${then}`, { timeout: 60000 });
    holds('live: who looks at another time and from elsewhere is left there', (await of(page, 'wingbeat.state.t')) === 0 && (await of(page, 'wingbeat.view.mode')) === 'side');
    await page.keyboard.press('1'); await page.keyboard.press('End'); await of(page, 'wingbeat.frame()');
    await page.screenshot({ path: path.join(pictures, 'live-flight.png') });
    const after = await of(page, 'wingbeat.version'), more = await (await fetch(`${address}data?after=${after}`)).text(), whole = await (await fetch(`${address}data?after=0`)).text();
    judge('live: news are a small part of the whole', more.length, more.length < 0.4 * whole.length, `below two fifths of ${whole.length} bytes`);
    // The page that took them bit by bit has what one that comes now has.
    const same = await page.evaluate(async text => {
      const news = JSON.parse(text), all = read(await inflated(news.bytes), news.data)[0], own = wingbeat.runs[0];
      const differs = (a, b) => ArrayBuffer.isView(a) ? Math.max(0, ...[...a].map((v, k) => Math.abs(v - b[k]) || 0)) : a && typeof a === 'object' ? Math.max(0, ...Object.keys(a).map(key => differs(a[key], b[key]))) : 0;
      return [differs(all.motion.position, own.motion.position), differs(all.motion.surfaces, own.motion.surfaces), differs([...all.axis.values], [...own.axis.values])];
    }, whole);
    judge('live: places on the page and in the whole', same.join(' '), same.every(d => d < 3e-3), '3 mm and 3 mN at most');
    // Who does not know the word is refused, and hanging browsers hold up nothing.
    const wrong = [new URL('/', address).href, address.replace(/.{33}$/, '0'.repeat(32) + '/')];
    for (const url of wrong) judge('live: refused without the word', (await fetch(url)).status, (await fetch(url)).status === 404, '404');
    const sockets = Array.from({ length: 12 }, () => net.connect(+new URL(address).port, '127.0.0.1').on('error', () => {}));
    await Promise.all(sockets.map(socket => new Promise(done => socket.once('connect', done))));
    let slowest = 0;
    for (let k = 0; k < 5; k++) {
      const begun = performance.now();
      await (await fetch(`${address}data?after=${1e9}`)).text();
      slowest = Math.max(slowest, performance.now() - begun);
    }
    most('live: slowest answer beside hanging browsers', slowest, 1000, 'ms');
    const hanging = await of(page, 'wingbeat.version');
    await page.waitForFunction(`wingbeat.version > ${hanging}`, { timeout: 4000 });
    holds('live: the page follows beside hanging browsers', (await said(page)) === 'live' && !(await of(page, 'wingbeat.ended')));
    sockets.forEach(socket => socket.destroy());
    // However long the flight takes here: its program stays until the page knows.
    await run.ended;
    await page.waitForFunction('wingbeat.ended', { timeout: 10000 });
    const end = await of(page, 'wingbeat.runs[0].axis.values.at(-1)');
    judge('live: it says the end when the flight is whole', end, (await said(page)) === 'ended' && Math.abs(end - LASTS) < 0.02, `at ${LASTS} s`);
    await page.screenshot({ path: path.join(pictures, 'live-ended.png') });
  });
  const code = await run.ended;
  holds('live: the run ends as it does without the page', [0, 3].includes(code), `exit code ${code}`);
  const plain = path.join(folder, 'live-plain'), child = spawn(process.env.WINGBEAT, ['fly', SCENARIO, ...LONG, '--quiet', '--force', '--out', plain]);
  await new Promise(done => child.on('exit', done));
  const files = root => fs.readdirSync(root, { recursive: true }).filter(file => fs.statSync(path.join(root, file)).isFile()).sort();
  const bytes = (root, file) => fs.readFileSync(path.join(root, file));
  // Times of the machine differ from run to run.
  const timeless = text => text.toString().replace(/"(real_time_factor|late|\w+_us)": *[-\d.e]+,?/g, '');
  const other = files(plain).filter(file => !/manifest.json|report.html/.test(file)).filter(file => /summary.json/.test(file) ? timeless(bytes(plain, file)) !== timeless(bytes(path.join(folder, 'live'), file)) : !bytes(plain, file).equals(bytes(path.join(folder, 'live'), file)));
  judge('live: files of the run that differ', other.join(' ') || 0, other.length === 0 && files(plain).join() === files(path.join(folder, 'live')).join(), '0');
  fs.rmSync(plain, { recursive: true });
}
{ // A program that is stopped says no end.
  await live('a flight that is stopped', ['fly', SCENARIO, ...LONG], async (page, _, run) => {
    await page.waitForFunction('wingbeat.version > 1', { timeout: 60000 });
    run.stop();
    await run.ended;
    await page.waitForFunction(`document.querySelector('[role=status]').dataset.word === 'no answer'`, { timeout: 10000 });
    holds('live: a program that was stopped does not answer, and has not ended well', !(await of(page, 'wingbeat.ended')));
  });
}
for (const [name, arguments_] of [['a search', ['trim', 'scenarios/cruise_20g.toml']], ['a fit', ['calibrate', 'calibrations/two_runs.toml']]]) {
  await live(name, arguments_, async (page, _, run) => {
    await Promise.race([run.ended, page.waitForFunction('wingbeat.ended || wingbeat.runs[0].axis.values.length > 3', { timeout: 120000 })]);
    judge(`live, ${name}: iterations on the page`, await rows(page), (await rows(page)) > 0, 'some');
    await page.screenshot({ path: path.join(pictures, `live-${name.replace('a ', '')}.png`) });
  }).then(run => run.ended);
}
const foreign = requests.filter(url => !url.startsWith('file:') && !url.startsWith('data:') && url !== 'about:blank');
const pages = requests.filter(url => url.startsWith('file:') && !/\.html(#|$)/.test(url));
most('network requests', foreign.length + pages.length, 0);
if (process.env.WRITE_REFERENCES) fs.writeFileSync(references, JSON.stringify(seen, null, 1) + '\n');
await browser.close();
console.log(`\n${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
