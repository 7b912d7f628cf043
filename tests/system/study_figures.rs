//! The results of the demonstration's study as its page, its codebook and its table say them, against packages that others wrote. Fails
//! when a figure is another than scipy and pingouin compute from the table, or the page rounds another than the codebook holds.

use std::fs;
use std::path::Path;
use std::process::Command;

use fantoccini::{Client, Locator};
use serde_json::json;
use tests::root;

/// Fewer would be a table that was not read.
const FEWEST: u32 = 1000;

/// Of an administrator who is signed in.
pub(super) async fn of(browser: &Client, url: &str, folder: &Path) {
    browser.goto(&format!("{url}/studies")).await.expect("the studies");
    let study = browser.find(Locator::Css("main table a[href^='/studies/']")).await.expect("a study");
    let href = study.attr("href").await.expect("an attribute").expect("an address");
    browser.goto(&format!("{url}{href}/results")).await.expect("the results");
    let page = folder.join("study.html");
    fs::write(&page, browser.source().await.expect("a page")).expect("a file");
    let fetched = |file: &'static str| {
        let (address, to) = (format!("{href}/results/{file}"), folder.join(file));
        async move {
            let script =
                "const [address, done] = arguments; fetch(address).then((answer) => answer.text()).then(done);";
            let text = browser.execute_async(script, vec![json!(address)]).await.expect("a script");
            fs::write(&to, text.as_str().expect("a text")).expect("a file");
            to
        }
    };
    let (table, book) = (fetched("study.csv").await, fetched("study.json").await);
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let checked = Command::new(root().join(python))
        .arg("tests/python/check_study.py")
        .args([&table, &book, &page])
        .current_dir(root())
        .output()
        .expect("python is missing: deploy/test makes its environment");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    let held = String::from_utf8_lossy(&checked.stdout).trim().to_owned();
    assert!(held.parse::<u32>().is_ok_and(|held| held >= FEWEST), "only {held} figures were held against each other");
}
