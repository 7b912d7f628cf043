//! A school's logo. Fails when it is shown to another school, when anything of the file is kept but its pixels, and when what is no
//! picture is taken.

use crate::people::school;
use crate::support::client::{Answer, Client, SentFile, csrf_in};

const PAGE: &str = "/admin/settings";

async fn send_logo(head: &mut Client, file: &[u8]) -> Answer {
    let csrf = csrf_in(&head.get(PAGE).await.text());
    let file = SentFile { field: "logo", name: "logo.png", bytes: file };
    head.form_with_file("/admin/settings/logo", &[("csrf", &csrf)], file).await
}

/// 600 × 120 pixels, and who has drawn it.
const LOGO: &[u8] = include_bytes!("../../data/logo.png");

#[tokio::test]
async fn a_logo_stands_on_every_page_of_its_school_and_nowhere_else() {
    let (app, _, mut head) = school().await;
    assert!(!head.get("/").await.text().contains("school-logo"));
    let sent = [LOGO, b"<script>"].concat();
    let taken = send_logo(&mut head, &sent).await;
    assert_eq!(taken.status, 303, "{}", taken.text());
    let page = head.get("/").await.text();
    let address =
        page.split("class=\"school-logo\" src=\"").nth(1).expect("a logo").split('"').next().unwrap().to_owned();
    let logo = head.get(&address).await;
    assert_eq!((logo.status.as_u16(), logo.header("content-type")), (200, "image/png"));
    assert_eq!(logo.body[16..24], [0, 0, 1, 224, 0, 0, 0, 96], "480 × 96 pixels");
    let has = |words: &[u8]| logo.body.windows(words.len()).any(|part| part == words);
    assert!(!has(b"<script>") && !has(b"Frau Beispiel"), "its pixels alone");

    let south = app.school("South").await;
    app.member(south, model::Role::Administrator, "other@example.org").await;
    let mut other = app.signed_in("other@example.org").await;
    assert_eq!(other.get(&address).await.status, 404, "each visitor is given the logo of their own school");
    assert!(!other.get("/").await.text().contains("school-logo"));

    let csrf = csrf_in(&head.get(PAGE).await.text());
    assert_eq!(head.form("/admin/settings/logo/remove", &[("csrf", &csrf)]).await.status, 303);
    assert_eq!(head.get(&address).await.status, 404);
}

#[tokio::test]
async fn what_is_no_picture_is_refused_in_words() {
    let (_app, _, mut head) = school().await;
    for hostile in [&b"<svg onload=\"alert(1)\"/>"[..], &LOGO[..60], b"", &vec![0; 5 * 1024 * 1024]] {
        let refused = send_logo(&mut head, hostile).await;
        assert!(refused.status == 422 && refused.text().contains("The logo:"), "{}", refused.text());
        assert!(!refused.text().contains("class=\"school-logo\""), "nothing has changed");
    }
}
