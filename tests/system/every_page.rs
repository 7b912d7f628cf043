//! Every page that the demonstration school links to, in every role. Called by [`super::browser`]. Fails when one of them breaks an
//! accessibility rule in light or dark, scrolls sideways, or has something that a mouse reaches and the Tab key does not, or
//! that does not show that it has the focus; and when a page is neither linked nor listed in docs/adopt/accessibility.md.

use std::collections::{BTreeSet, VecDeque};

use fantoccini::Client;
use fantoccini::actions::{InputSource, KeyAction, KeyActions};
use fantoccini::key::Key;
use serde_json::{Value, json};
use tests::root;

use super::browser::{inspect, sign_in};

/// Parts of an address after which a name stands that means one of many.
const NAMED: [&str; 4] = ["exercises", "curricula", "instruments", "join"];
/// Addresses without a dot that answer a file, a program or a redirection.
const NO_PAGES: [&str; 15] = [
    "/assets/{}",
    "/badges/status/{}",
    "/calendar/{}",
    "/drafts/{}/pictures",
    "/drafts/{}/pictures/{}",
    "/exercises/{}/pictures/{}",
    "/healthz",
    "/metrics",
    "/readyz",
    "/recordings/{}/{}",
    "/school/logo",
    "/sessions/{}/exam-files/{}",
    "/studies/{}/results/{}",
    "/surveys/instruments/{}/{}",
    "/surveys/{}/results/{}",
];
/// What the Tab key must come to, and a note of what it comes to. Of a group of radio buttons it comes to one.
const WATCH: &str = r#"
    const name = e => (e.outerHTML.match(/^<[^>]*>/) || [''])[0].slice(0, 160);
    const seen = window.seen = new Set();
    const hidden = window.hidden = new Set();
    const groups = new Set();
    const first = e => e.type !== 'radio' || (!groups.has(e.name) && groups.add(e.name));
    const reachable = [...document.querySelectorAll('a[href], button, input, select, textarea, summary, [tabindex], [role=slider]')]
        .filter(e => e.checkVisibility({ visibilityProperty: true }) && !e.disabled && e.type !== 'hidden' && first(e))
        .filter(e => e.getAttribute('tabindex') !== '-1' || e.matches('a, button, input, select, textarea'));
    window.missed = () => reachable.filter(e => !seen.has(e) && !(e.type === 'radio' && [...seen].some(s => s.name === e.name))).map(name);
    window.unmarked = () => [...hidden].map(name);
    document.addEventListener('focusin', ({ target }) => {
        seen.add(target);
        const style = getComputedStyle(target);
        if (style.outlineStyle === 'none' && style.boxShadow === 'none') hidden.add(target);
    });
    document.activeElement.blur();
    return reachable.length + 7 * reachable.filter(e => String(e.type).startsWith('date')).length; // a day and a time have fields of their own"#;

/// Addresses of pages in the service that the open page links to.
const LINKS: &str =
    "return [...document.querySelectorAll('a[href^=\"/\"]:not([download])')].map(a => a.pathname + a.search)";

/// What the service answered.
const STATUS: &str = "return performance.getEntriesByType('navigation')[0].responseStatus";

/// A page's address without what names one of many, or says more of it.
fn shape(address: &str) -> String {
    let path = address.split('?').next().unwrap_or_default();
    let mut before = "";
    let mut parts = Vec::new();
    for part in path.split('/') {
        let is_one_of_many = uuid::Uuid::parse_str(part).is_ok() || NAMED.contains(&before);
        parts.push(if is_one_of_many { "{}" } else { part });
        before = part;
    }
    parts.join("/")
}

/// Presses Tab as often as it takes to come to everything once, and tells what it missed.
async fn keyboard(browser: &Client, what: &str) {
    let reachable =
        browser.execute(WATCH, vec![]).await.expect("the page counts what can be reached").as_u64().unwrap_or(0);
    let presses = (0..=reachable).fold(KeyActions::new("keyboard".to_owned()), |keys, _| {
        keys.then(KeyAction::Down { value: Key::Tab.into() }).then(KeyAction::Up { value: Key::Tab.into() })
    });
    browser.perform_actions(presses).await.expect("Tab is pressed");
    for (list, why) in [("missed", "is not reached by Tab"), ("unmarked", "does not show that it has the focus")] {
        let found = browser.execute(&format!("return window.{list}()"), vec![]).await.expect("a list");
        assert_eq!(found, json!([]), "{what}: {why}");
    }
}

/// Signs a user in and opens every page that links lead to, one of each shape; returns the shapes.
pub(super) async fn of(browser: &Client, url: &str, (role, email): (&str, &str)) -> BTreeSet<String> {
    sign_in(browser, url, email).await;
    let mut waiting = VecDeque::from([("/".to_owned(), "nowhere".to_owned())]);
    let mut known = BTreeSet::from(["/".to_owned()]);
    while let Some((path, from)) = waiting.pop_front() {
        browser.goto(&format!("{url}{path}")).await.expect("the page opens");
        let what = format!("{path}, linked to on {from}, of the {role}");
        assert_eq!(browser.execute(STATUS, vec![]).await.expect("a status"), json!(200), "{what}");
        inspect(browser, &what).await;
        keyboard(browser, &what).await;
        let Value::Array(links) = browser.execute(LINKS, vec![]).await.expect("the page's links") else { continue };
        let links = links.iter().filter_map(Value::as_str).filter(|path| is_page(path));
        waiting.extend(links.filter(|to| known.insert(shape(to))).map(|to| (to.to_owned(), path.clone())));
    }
    assert!(known.len() > 8, "pages of the {role}: {known:?}");
    known
}

/// Pages of the service, by the list of its routes.
pub(super) fn listed_pages() -> BTreeSet<String> {
    let table =
        std::fs::read_to_string(root().join("web-admin/tests/main/every_route.txt")).expect("the list of routes");
    let paths = table.lines().filter_map(|line| line.strip_prefix("GET ")?.split_whitespace().next());
    let named = |part: &str| if part.starts_with('{') { "{}".to_owned() } else { part.to_owned() };
    let shapes = paths.map(|path| shape(&path.split('/').map(named).collect::<Vec<_>>().join("/")));
    let is_program = |path: &str| path.starts_with("/scim/") || path.starts_with("/.well-known/");
    shapes.filter(|path| is_page(path) && !is_program(path) && !NO_PAGES.contains(&path.as_str())).collect()
}

/// Pages that the report on accessibility lists because no link of the demonstration school leads to them.
pub(super) fn unlinked_pages() -> BTreeSet<String> {
    let report = std::fs::read_to_string(root().join("docs/adopt/accessibility.md")).expect("the report");
    let list = report.split("\n## Pages outside the crawl\n").nth(1).expect("the list of pages");
    let cells = list.lines().filter(|line| line.starts_with("| `/")).filter_map(|line| line.split('|').nth(1));
    cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
}

/// Compares the pages that the browser has opened with those of the service.
pub(super) fn compare(opened: &BTreeSet<String>) {
    let unlinked = unlinked_pages();
    let listed = listed_pages();
    let missing: Vec<_> = listed.iter().filter(|page| !opened.contains(*page) && !unlinked.contains(*page)).collect();
    assert!(missing.is_empty(), "link to these pages, or list them in docs/adopt/accessibility.md: {missing:?}");
}

#[test]
fn accessibility_report_lists_pages_of_the_service() {
    let (listed, unlinked) = (listed_pages(), unlinked_pages());
    assert!(listed.len() > 80 && unlinked.len() > 10, "{} pages, {} unlinked", listed.len(), unlinked.len());
    let gone: Vec<_> = unlinked.difference(&listed).collect();
    assert!(gone.is_empty(), "docs/adopt/accessibility.md lists pages that are gone: {gone:?}");
}

/// Whether an address is a page, not a file or a program's.
fn is_page(address: &str) -> bool {
    let path = shape(address);
    let last = path.rsplit('/').next().unwrap_or_default();
    !last.contains('.') && !path.starts_with("/api/") && path != "/account/export"
}
