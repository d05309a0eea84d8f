// Put behind the page's own scripts: uses every control and writes what it sees into the page.
(async () => {
  const seen = {};
  try { await act(seen); } catch (error) { complaints.push(String(error)); }
  seen.complaints = complaints;
  const box = document.createElement("pre");
  box.id = "seen"; box.textContent = JSON.stringify(seen);
  document.body.append(box);
})();

async function act(seen) {
  const wait = ms => new Promise(done => setTimeout(done, ms));
  for (let tries = 0; document.body.dataset.ready !== "yes" && tries < 900; tries++) await wait(100);
  const all = query => [...document.querySelectorAll(query)];
  const panels = all(".panel");
  const visible = () => panels.flatMap(node => node.data.filter(trace => trace.visible !== false).map(trace => trace.meta.method));
  seen.panels = panels.length;
  seen.drawn = panels.filter(node => node.querySelector(".scatterlayer .trace path")).length;
  seen.hover = document.querySelector('[data-plot="decay"].panel').data.at(-1).hovertemplate;
  seen.before = [...new Set(visible())].sort();
  const button = document.querySelector('.methods [data-method="split"]');
  button.click(); await wait(200);
  seen.alone = [...new Set(visible())].sort();
  seen.pressed = button.getAttribute("aria-pressed");
  seen.beam = document.querySelector(".motion .model").value;
  button.click(); await wait(200);
  seen.again = [...new Set(visible())].sort();
  const cost = document.querySelector('[data-plot="accuracy_cost"].panel');
  seen.scales = [cost.layout.yaxis.type];
  document.querySelector('.scale[data-plot="accuracy_cost"]').click(); await wait(200);
  seen.scales.push(cost.layout.yaxis.type);
  const table = document.querySelector('[data-name="decay"]'), column = () => [...table.tBodies[0].rows].map(row => row.cells[2].textContent);
  const heading = table.tHead.rows[0].cells[2].querySelector("button");
  heading.click(); seen.rising = column();
  heading.click(); seen.falling = column();
  seen.sort = table.tHead.rows[0].cells[2].getAttribute("aria-sort");
  const filter = table.closest("article").querySelector(".filter");
  filter.value = "small split"; filter.dispatchEvent(new Event("input"));
  seen.left = [...table.tBodies[0].rows].filter(row => !row.hidden).map(row => row.textContent);
  const slider = document.querySelector(".motion .time"), now = document.querySelector(".motion .now");
  seen.times = [now.textContent];
  slider.value = 7; slider.dispatchEvent(new Event("input"));
  seen.times.push(now.textContent);
  seen.said = document.querySelector(".motion canvas").getAttribute("aria-label");
  const canvas = document.querySelector(".motion canvas");
  seen.ink = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.filter((value, at) => at % 4 === 3 && value > 0).length;
  seen.csv = Plots.csv("decay").split("\n").length;
  seen.wide = document.documentElement.scrollWidth - innerWidth;
  seen.fetched = performance.getEntriesByType("resource").map(entry => entry.name).filter(name => !/^(data|blob):/.test(name));
}
