// a plot is drawn when it comes near the window: all of a large report at once would take half a minute
const near = new IntersectionObserver(entries => {
  for (const {isIntersecting, target} of entries) {
    if (!isIntersecting) continue;
    near.unobserve(target);
    Bokeh.embed.embed_item(JSON.parse(target.querySelector("script").textContent), target);
  }
}, {rootMargin: "600px"});
document.querySelectorAll(".plot").forEach(plot => near.observe(plot));

// a link to a section that is closed opens it
const reveal = hash => document.querySelector(`section[id="${hash.slice(1)}"] > details`)?.setAttribute("open", "");
addEventListener("hashchange", () => reveal(location.hash));
addEventListener("click", event => reveal(event.target.closest?.("a[href^='#']")?.hash ?? ""));
reveal(location.hash);
