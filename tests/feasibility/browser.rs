//! The page in a browser: headless Chromium, as Debian has it.

use std::{fs, path::Path};

use serde_json::Value;

use super::{SCENE, amacrine, common::chromium, folder};

/// Looks at the page in a frame of a phone's width, and writes down what it finds.
const PROBE: &str = r"<!doctype html><meta charset=utf-8><title>probe</title><pre id=found></pre>
<iframe id=page width=360 height=780 srcdoc='PAGE'></iframe>
<script>
document.getElementById('page').addEventListener('load', event => {
  const page = event.target.contentDocument, root = page.documentElement;
  const all = what => [...page.querySelectorAll(what)];
  const name = element => element.computedName;
  document.getElementById('found').textContent = JSON.stringify({
    width: root.clientWidth,
    scroll: root.scrollWidth,
    height: root.scrollHeight,
    images: all('img').map(i => i.complete && i.naturalWidth > 0),
    drawings: all('svg[role=img], svg.bar').map(s => s.getBoundingClientRect().width > 0),
    names: all('img, svg[role=img], section, table, [role=region]').map(e => [e.tagName, e.computedRole, name(e)]),
    headings: all('h1, h2').map(h => name(h)),
    regions: all('.wide').map(w => w.tabIndex),
    hidden: all('.wide').filter(w => w.scrollWidth > w.clientWidth + 1)
      .filter(w => { const hint = w.previousElementSibling; return !hint || !hint.matches('.hint') || hint.offsetHeight === 0; })
      .map(w => name(w)),
    scrolling: all('.wide').filter(w => w.scrollWidth > w.clientWidth + 1).length,
    outside: all('main *').filter(e => !e.closest('.wide, pre, svg') && e.getBoundingClientRect().right > root.clientWidth + 1).map(e => e.outerHTML.slice(0, 80)),
    small: all('p, li, td, th, dd, dt, figcaption').filter(e => parseFloat(getComputedStyle(e).fontSize) < 11).length,
  });
});
</script>";

#[test]
#[ignore = "needs chromium"]
fn a_browser_shows_prints_and_reads_it_out() {
    let folder = folder();
    let folder = folder.path();
    for kernels in ["csdvs-3,sobel-x", "rgc-5x5"] {
        fits_a_phone(folder, kernels);
    }
    for (name, width, height) in [("phone", 500, 900), ("desktop", 1280, 900)] {
        let file = format!("{name}.png");
        let size = format!("--window-size={width},{height}");
        chromium(
            folder,
            &[&size, &format!("--screenshot={file}"), "report.html"],
        );
        let shot = image::open(folder.join(&file)).unwrap().to_rgb8();
        assert_eq!(shot.dimensions().0, width);
        let dark = shot
            .pixels()
            .filter(|pixel| pixel.0.iter().all(|v| *v < 100))
            .count();
        assert!(dark > 2000, "{name}: nothing is written");
    }
    chromium(folder, &["--print-to-pdf=report.pdf", "report.html"]);
    let pdf = fs::read(folder.join("report.pdf")).unwrap();
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 20_000);
}

/// At 360 px nothing is wider than the screen but what scrolls by itself and says so.
fn fits_a_phone(folder: &Path, kernels: &str) {
    let ask = [
        "feasibility",
        "--kernel",
        kernels,
        "--threshold",
        "100",
        "--scene",
        SCENE,
        "--candidates",
        "ternary,int-4",
        "--effort",
        "0.05",
        "-o",
        "report.html",
    ];
    amacrine(folder, &ask).assert().success();
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    let inside = page.replace('&', "&amp;").replace('\'', "&#39;");
    fs::write(folder.join("probe.html"), PROBE.replace("PAGE", &inside)).unwrap();

    let names = "--enable-blink-features=ComputedAccessibilityInfo";
    let (dom, _) = chromium(folder, &[names, "--dump-dom", "probe.html"]);
    let found = dom.split_once("<pre id=\"found\">").unwrap().1;
    let found = found.split_once("</pre>").unwrap().0;
    let found = found
        .replace("&amp;", "&")
        .replace("&lt;", "<")
        .replace("&gt;", ">");
    let found: Value = serde_json::from_str(&found).unwrap();
    assert_eq!(found["width"], 360);
    assert!(
        found["scroll"].as_u64() <= Some(360),
        "the page is wider than a phone"
    );
    let images = found["images"].as_array().unwrap();
    assert!(images.len() >= 5 && images.iter().all(|loaded| loaded == true));
    let none = serde_json::json!([]);
    assert_eq!(found["hidden"], none, "it scrolls, and does not say so");
    assert_eq!(found["outside"], none, "cut off at the right");
    assert!(found["scrolling"].as_u64() > Some(3));
    let drawings = found["drawings"].as_array().unwrap();
    assert!(drawings.len() > 6 && drawings.iter().all(|seen| seen == true));
    let names = found["names"].as_array().unwrap();
    assert!(names.len() > 20);
    for name in names {
        let said = name[2].as_str().unwrap();
        assert!(!said.trim().is_empty(), "{name} has no name");
    }
    let heading = format!("{} on scamp5", kernels.replace(',', ", "));
    assert_eq!(found["headings"][0], heading);
    assert_eq!(found["small"], 0);
}
