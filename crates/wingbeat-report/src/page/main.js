// The page: the runs that it holds, and those of a computation that it follows.
class Page {
  constructor() {
    this.stage = new Stage(t => this.plots && this.plots.mark(t));
    this.controls = new Controls(this.stage);
    const of = this;
    window.wingbeat = {
      get runs() { return of.runs; }, get state() { return of.stage.state; }, get view() { return of.stage.view; }, get camera() { return of.stage.camera; },
      get frames() { return of.stage.frames; }, get low() { return of.stage.low; }, get high() { return of.stage.high; }, get renderer() { return of.stage.renderer && of.stage.renderer.kind; },
      seek: t => of.stage.seek(t), sharpen: () => of.stage.sharpen(), play: on => of.stage.play(on), frame: () => { of.stage.state.dirty = true; of.stage.frame(); },
    };
  }
  // Numbers and settings below the plots.
  tell(runs) {
    const open = [...$('told').querySelectorAll('details')].map(details => details.open);
    $('told').replaceChildren(...(runs.length > 1 ? [together(runs)] : []), ...runs.map(run => told(run, runs.length > 1)));
    $('told').querySelectorAll('details').forEach((details, k) => details.open = !!open[k]);
  }
  // Shows runs, or what these have `more` than those that are shown.
  async show(data, letters, more) {
    try {
      const runs = read(await inflated(letters), data);
      this.runs = more ? runs.map((run, k) => ({ ...longer(this.runs[k], run), ...data.runs[k] })) : runs;
      this.tell(this.runs);
    }
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
// Asks for what has been computed meanwhile until the program says that the computation has ended; who stands at the end goes with it.
async function follow(page) {
  const line = make('p', { class: 'verdict', role: 'status' }), here = location.pathname.replace(/\/$/, '');
  $('verdicts').before(line);
  const tell = (word, text) => { if (line.dataset.word !== word) { line.dataset.word = word; line.replaceChildren(make('b', { class: 'quiet' }, word), text); } };
  for (let version = +document.documentElement.dataset.live, misses = 0, ended = false; !ended;) {
    let news = null;
    try {
      const answer = await fetch(`${here}/data?after=${version}`, { cache: 'no-store' });
      if (!answer.ok) throw new Error(answer.status);
      if (answer.status === 200) news = await answer.json();
    } catch {
      // One miss is no news; later ones are asked again ever more slowly.
      if (++misses > 1) tell('no answer', 'the program has ended or does not answer; the page asks again');
      await pause(Math.min(5000, 300 * misses)); continue;
    }
    misses = 0;
    if (news) {
      ({ version, ended } = news);
      $('verdicts').replaceChildren(...news.data.runs.map(verdict));
      await page.show(news.data, news.bytes, news.after !== undefined);
    }
    if (ended) tell('ended', 'the computation has ended; the program then writes its run folder'); else tell('live', 'the computation goes on');
    Object.assign(window.wingbeat, { version, ended });
    if (!ended) await pause(500);
  }
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
