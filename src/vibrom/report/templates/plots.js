"use strict";
// The plots of the page: drawn by Plotly from the data in #plots-data, in the colours of the page.
const Plots = (() => {
  const plots = JSON.parse(document.getElementById("plots-data").textContent);
  const panels = [...document.querySelectorAll(".panel")];
  const state = { alone: "", linear: new Set() };
  const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const figureOf = node => plots[node.dataset.plot][node.dataset.panel];

  // Plotly's code lies compressed in the page: 1.5 MB instead of 4.8.
  async function library() {
    const bytes = Uint8Array.from(atob(document.getElementById("plotly-code").textContent), c => c.charCodeAt(0));
    const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
    const script = document.createElement("script");
    script.textContent = text;
    document.head.append(script);
  }

  function numbers(values) {
    if (!values || !values.bdata) return values;
    const bytes = Uint8Array.from(atob(values.bdata), c => c.charCodeAt(0));
    return Array.from(new Float32Array(bytes.buffer), value => Number.isFinite(value) ? value : null);
  }

  for (const figures of Object.values(plots))
    for (const figure of figures)
      for (const trace of figure.data) {
        trace.y = numbers(trace.y);
        trace.x = trace.x ? numbers(trace.x) : trace.y.map((_, index) => trace.x0 + index * trace.dx);
        delete trace.x0; delete trace.dx;
      }

  // Dark colours would drown on a dark page: they are mixed with white there.
  function shade(colour) {
    if (colour === "#1c2126") return css("--ink");
    if (!dark() || !/^#[0-9a-f]{6}$/i.test(colour)) return colour;
    const parts = [1, 3, 5].map(at => Math.round(0.62 * parseInt(colour.slice(at, at + 2), 16) + 0.38 * 255));
    return `rgb(${parts.join(",")})`;
  }
  const page = document.documentElement, printing = () => "printing" in page.dataset; // light, whatever the screen is
  const dark = () => !printing() && matchMedia("(prefers-color-scheme: dark)").matches;

  function coloured(trace) {
    const copy = { ...trace, showlegend: false, visible: shown(trace) };
    if (trace.line) copy.line = { ...trace.line, color: shade(trace.line.color) };
    if (trace.marker)
      copy.marker = { ...trace.marker, color: shade(trace.marker.color), line: { ...trace.marker.line, color: shade(trace.marker.line.color) } };
    if (trace.error_y) copy.error_y = { ...trace.error_y, color: shade(trace.error_y.color) };
    return copy;
  }

  const shown = trace => !state.alone || trace.meta.method === "full_order" || trace.meta.method === state.alone;

  // Ticks at 1, 2 and 5 where there are few powers of ten between the smallest and the largest value.
  function decades(figure, name) {
    const values = figure.data.flatMap(trace => [...trace[name]]).filter(value => value > 0);
    return Math.log10(Math.max(...values) / Math.min(...values));
  }

  function layout(figure, linear) {
    const axis = (own, name) => {
      const made = { ...own, gridcolor: css("--rule"), zerolinecolor: css("--rule"), linecolor: css("--soft"), automargin: true,
        exponentformat: "power", title: { ...own.title, font: { size: 12 }, standoff: 6 } };
      if (linear && figure.switch.includes(name)) {
        made.type = own.type === "log" ? "linear" : "log";
        delete made.range;
      }
      if (made.type === "log") Object.assign(made, { tickformat: "~g", dtick: decades(figure, name) < 2.3 ? "D2" : 1 });
      return made;
    };
    return {
      xaxis: axis(figure.layout.xaxis, "x"), yaxis: axis(figure.layout.yaxis, "y"),
      title: { text: figure.title, x: 0, xanchor: "left", font: { size: 13 } },
      margin: { l: 8, r: 8, t: 30, b: 8 }, height: 300, hovermode: "closest", dragmode: "zoom",
      paper_bgcolor: css("--paper"), plot_bgcolor: css("--paper"),
      font: { color: css("--ink"), family: getComputedStyle(document.body).fontFamily, size: 11 },
      hoverlabel: { bgcolor: css("--band"), font: { color: css("--ink") } },
    };
  }

  const PRINTED = { width: 264, height: 205, autosize: false }; // [px] four panels across a page, which shrinks them
  function draw(node) {
    const figure = figureOf(node);
    const size = printing() ? PRINTED : { width: undefined, autosize: true };
    const config = { responsive: true, displaylogo: false, displayModeBar: false, showTips: false };
    node.dataset.drawn = "yes";
    return Plotly.react(node, figure.data.map(coloured), { ...layout(figure, state.linear.has(node.dataset.plot)), ...size }, config);
  }

  const redraw = () => panels.filter(node => node.dataset.drawn).forEach(draw);

  // One method beside the full order, in all plots and in the moving beam; the same again shows all.
  function alone(method) {
    state.alone = state.alone === method ? "" : method;
    for (const button of document.querySelectorAll(".methods button"))
      button.setAttribute("aria-pressed", String(button.dataset.method === state.alone));
    for (const node of panels.filter(node => node.dataset.drawn))
      Plotly.restyle(node, { visible: figureOf(node).data.map(shown) });
    document.dispatchEvent(new CustomEvent("method", { detail: state.alone }));
  }

  function scale(button) {
    const name = button.dataset.plot;
    state.linear.has(name) ? state.linear.delete(name) : state.linear.add(name);
    button.setAttribute("aria-pressed", String(state.linear.has(name)));
    panels.filter(node => node.dataset.plot === name).forEach(draw);
  }

  function csv(name) {
    const quoted = text => `"${String(text).replaceAll('"', '""')}"`;
    const rows = plots[name].flatMap(figure => figure.data.flatMap(trace => trace.y.map((y, at) =>
      [quoted(figure.title), quoted(trace.name), trace.meta.method, trace.x[at], y ?? ""].join(","))));
    return ["panel,line,method,x,y", ...rows].join("\n") + "\n";
  }

  function save(name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([csv(name)], { type: "text/csv" }));
    link.download = `${name}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  // What is in view first, the rest when the browser has nothing else to do.
  async function start() {
    await library();
    const seen = new IntersectionObserver(entries => {
      for (const entry of entries) if (entry.isIntersecting && !entry.target.dataset.drawn) draw(entry.target);
    }, { rootMargin: "300px" });
    panels.forEach(node => seen.observe(node));
    const idle = window.requestIdleCallback || (work => setTimeout(work, 20));
    const next = () => {
      const left = panels.find(node => !node.dataset.drawn);
      if (left) { draw(left); idle(next); } else document.body.dataset.ready = "yes";
    };
    idle(next);
  }

  document.querySelectorAll(".methods button").forEach(button => button.addEventListener("click", () => alone(button.dataset.method)));
  document.querySelectorAll("button.scale").forEach(button => button.addEventListener("click", () => scale(button)));
  document.querySelectorAll("button.csv").forEach(button => button.addEventListener("click", () => save(button.dataset.plot)));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => { page.dataset.printing = "yes"; panels.forEach(draw); });
  addEventListener("afterprint", () => { delete page.dataset.printing; redraw(); });
  start();
  return { alone, csv, state };
})();
