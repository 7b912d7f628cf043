//! Certificates and transcripts as PDF. Fails when a PDF certifies something else than the page, when the same certificate has other bytes, or
//! when a school's signatory is not on paper.

use acts::training::certificates;
use model::training::certificate::check_certificate;
use web_admin::worker;

use super::certificates::school;
use crate::support::client::csrf_in;
use crate::support::recordings::{Attempt, FORGED, record};

const SETTINGS: [(&str, &str); 4] =
    [("name", "North & Sons"), ("time_zone", "UTC"), ("letter_language", "en"), ("replaced_grace_days", "7")];

#[tokio::test]
async fn a_pdf_certifies_what_the_page_certifies() {
    let (app, ada) = school().await;
    app.with_token(&ada.token).upload(&record(&Attempt { bundle: &FORGED, ..Attempt::default() })).await;
    worker::work_off_jobs(&app.state).await.unwrap();
    let mut head = app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/admin").await.text());
    assert_eq!(head.form("/admin/certificate-needs", &[("csrf", &csrf), ("needed", "nothing")]).await.status, 303);
    let signed = [("csrf", csrf.as_str()), ("signatory_name", "Prof. Bö"), ("signatory_function", "Dean")];
    assert_eq!(head.form("/admin/settings", &[&signed[..], &SETTINGS].concat()).await.status, 303);

    let mut browser = app.signed_in("ada@example.org").await;
    let csrf = csrf_in(&browser.get("/account").await.text());
    let address = format!("/trainees/{}/certificates/one-step", ada.person.id);
    let page = browser.form(&address, &[("csrf", &csrf)]).await;
    assert!(page.text().contains("Prof. Bö") && page.text().contains("Dean"), "{}", page.text());
    let pdf = browser.form(&address, &[("csrf", &csrf), ("format", "pdf")]).await;
    assert_eq!((pdf.status.as_u16(), pdf.header("content-type")), (200, "application/pdf"));
    assert!(pdf.header("content-disposition").contains("certificate-one-step.pdf"));
    let key = certificates::public_key(&app.state.config.keys_dir).unwrap();
    let stated = check_certificate(&pdf.body, &key).unwrap();
    assert_eq!(stated, check_certificate(&page.body, &key).unwrap());
    let again = browser.form(&address, &[("csrf", &csrf), ("format", "pdf")]).await;
    assert!(again.body == pdf.body, "the same certificate has the same bytes");
    assert_eq!(browser.form(&address, &[("csrf", &csrf), ("format", "docx")]).await.status, 400);

    let transcript = browser.get(&format!("/trainees/{}/transcript.pdf", ada.person.id)).await;
    assert_eq!((transcript.status.as_u16(), transcript.header("content-type")), (200, "application/pdf"));
    assert!(
        transcript.body.starts_with(b"%PDF-1.7") && transcript.header("content-disposition").contains("transcript")
    );
    if let Some(folder) = std::env::var_os("STYLET_KEEP_PAPERS").map(std::path::PathBuf::from) {
        std::fs::write(folder.join("certificate.pdf"), &pdf.body).unwrap();
        std::fs::write(folder.join("certificate.html"), &page.body).unwrap();
        std::fs::write(folder.join("transcript.pdf"), &transcript.body).unwrap();
    }
}

#[tokio::test]
async fn a_function_needs_the_name_of_a_signatory() {
    let (app, _) = school().await;
    let mut head = app.signed_in("head@example.org").await;
    let csrf = csrf_in(&head.get("/admin").await.text());
    for (name, function) in [("", "Dean"), (&*"x".repeat(121), ""), ("Bo", &*"x".repeat(121))] {
        let signed = [("csrf", csrf.as_str()), ("signatory_name", name), ("signatory_function", function)];
        let refused = head.form("/admin/settings", &[&signed[..], &SETTINGS].concat()).await;
        assert_eq!(refused.status, 422, "{name} {function}");
        assert!(refused.text().contains("signatory:") && refused.text().contains(function), "{}", refused.text());
    }
}
