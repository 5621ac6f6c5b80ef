// The page: the runs that it holds, and those of a computation that it follows.
class Page {
  constructor() {
    this.stage = new Stage(t => this.plots && this.plots.mark(t));
    this.controls = new Controls(this.stage);
    const of = this;
    window.wingbeat = {
      get runs() { return of.runs; }, get state() { return of.stage.state; }, get view() { return of.stage.view; }, get camera() { return of.stage.camera; },
      get frames() { return of.stage.frames; }, get low() { return of.stage.low; }, get high() { return of.stage.high; }, get renderer() { return of.stage.renderer && of.stage.renderer.kind; },
      seek: t => of.stage.seek(t), play: on => of.stage.play(on), frame: () => { of.stage.state.dirty = true; of.stage.frame(); },
    };
  }
  // Numbers and settings below the plots.
  tell(runs) {
    const open = [...$('told').querySelectorAll('details')].map(details => details.open);
    $('told').replaceChildren(...(runs.length > 1 ? [together(runs)] : []), ...runs.map(run => told(run, runs.length > 1)));
    $('told').querySelectorAll('details').forEach((details, k) => details.open = !!open[k]);
  }
  async show(data, letters) {
    try { this.runs = read(await inflated(letters), data); this.tell(this.runs); }
    catch (error) { this.tell(data.runs); $('verdicts').append(make('p', { class: 'verdict bad' }, 'Nothing can be drawn: ' + error.message)); return false; }
    const { stage } = this, motions = this.runs.filter(run => run.motion && run.axis.values.length > 1).map(run => Object.assign(new Motion(run), { run }));
    const shots = motions.length ? [] : this.runs.flatMap(run => run.shots.map(shot => ({ ...shot, run })));
    if (this.plots) this.plots.away();
    this.plots = new Plots(this.runs, $('plots'), t => { stage.seek(t); stage.frame(); });
    const drawn = motions.length || shots.length;
    document.querySelector('main').classList.toggle('flat', !drawn);
    $('stage').hidden = !drawn;
    stage.load(motions, shots, this.plots);
    this.controls.offer(motions, shots);
    return drawn;
  }
}
// Asks for what has been computed meanwhile until the computation has ended; the page goes with it as long as it stands at the end.
async function follow(page) {
  const line = make('p', { class: 'verdict', role: 'status' }), here = location.pathname.replace(/\/$/, '');
  $('verdicts').before(line);
  const tell = (word, kind, text) => line.replaceChildren(make('b', { class: kind }, word), text);
  tell('live', 'quiet', 'the computation goes on');
  for (let version = 0, misses = 0, ended = false; !ended;) {
    let answer;
    try { answer = await fetch(`${here}/data?after=${version}`, { cache: 'no-store' }); if (!answer.ok) throw new Error(answer.status); misses = 0; }
    catch { if (++misses > 2) { tell('ended', 'quiet', 'the computation has ended; its run folder holds the whole page'); break; } await pause(300); continue; }
    const news = answer.status === 200 ? await answer.json() : null;
    if (news) {
      ({ version, ended } = news);
      $('verdicts').replaceChildren(...news.data.runs.map(verdict));
      await page.show(news.data, news.bytes);
      tell(ended ? 'ended' : 'live', 'quiet', ended ? 'the computation has ended; its run folder holds the whole page' : 'the computation goes on');
    }
    window.wingbeat.version = version; window.wingbeat.ended = ended;
    await pause(500);
  }
  window.wingbeat.ended = true;
}
const pause = ms => new Promise(done => setTimeout(done, ms));
(async () => {
  const data = JSON.parse($('data').textContent), live = document.documentElement.dataset.live !== undefined, page = new Page();
  $('verdicts').replaceChildren(...data.runs.map(verdict));
  // What has been written is seen before anything is computed.
  await new Promise(painted => requestAnimationFrame(() => setTimeout(painted)));
  page.stage.follows = live;
  const drawn = await page.show(data, $('bytes').textContent);
  $('bytes').textContent = '';
  const start = /t=([\d.]+)/.exec(location.hash);
  if (start) page.stage.seek(+start[1]);
  page.stage.frame();
  if (drawn && !live && !page.stage.still.matches && !start && !location.hash.includes('still')) page.stage.play(true);
  window.wingbeat.ready = true;
  if (live) follow(page);
})();
