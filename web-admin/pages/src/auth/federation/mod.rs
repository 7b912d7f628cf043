//! Pages of the sign-in with accounts of other systems.

mod providers;

use askama::Template;
use askama_web::WebTemplate;
use model::auth::federation::IdentityOrigin;
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::ProviderId;
pub use providers::{ClaimsPage, ProviderForm, ProviderPage, ProviderRow, ProvidersPage};
use time::OffsetDateTime;

use crate::{Shell, assets, format};

/// A button that leads to a provider.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProviderButton {
    /// Address of its form.
    pub href: String,
    /// Name of the provider.
    pub name: String,
    /// Name of the school, if several are shown.
    pub school: Option<String>,
}

/// The page before the browser leaves for the provider.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/leave.html")]
pub struct LeavePage {
    /// Name of the provider.
    pub provider: String,
    /// Host of the provider.
    pub host: String,
    /// Address of the provider's page.
    pub address: String,
}

/// The page that explains why a sign-in was refused.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/refused.html")]
pub struct SignInRefusedPage {
    /// The reason.
    pub reason: SignInRefusal,
}

/// The page for a person whom no account knows yet.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/unknown.html")]
pub struct UnknownPersonPage {
    /// CSRF token.
    pub csrf: String,
    /// Name of the provider.
    pub provider: String,
    /// Name of the person at the provider.
    pub name: String,
    /// Email address to join, as entered.
    pub email: String,
    /// Whether a new account can be created.
    pub creates: bool,
    /// Why the previous attempt failed.
    pub error: Option<String>,
}

/// A provider to join or to confirm with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProviderChoice {
    /// Id.
    pub id: ProviderId,
    /// Name.
    pub name: String,
}

/// The page of the accounts that open the user's account.
#[derive(Debug, Template, WebTemplate)]
#[template(path = "auth/federation/identities.html")]
pub struct IdentitiesPage {
    /// Page frame.
    pub shell: Shell,
    /// Joined accounts, oldest first.
    pub rows: Vec<IdentityRow>,
    /// Enabled providers of the school.
    pub providers: Vec<ProviderChoice>,
    /// Path to open after the user has confirmed who they are.
    pub next: String,
    /// Why a change was refused.
    pub refused: Option<String>,
}

/// A joined account.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdentityRow {
    /// Name of the provider, or its issuer.
    pub provider: String,
    /// Id of the person there.
    pub subject: String,
    /// How it was joined.
    pub how: IdentityOrigin,
    /// When it was joined.
    pub made: OffsetDateTime,
    /// When it was last used.
    pub used: Option<OffsetDateTime>,
    /// Address that removes it.
    pub remove_href: String,
}

impl IdentityRow {
    fn said_how(&self) -> &'static str {
        match self.how {
            IdentityOrigin::Created => tr!("with this account"),
            IdentityOrigin::Matched => tr!("recognized by number or address"),
            IdentityOrigin::Joined => tr!("by you"),
            IdentityOrigin::ByAdministrator => tr!("by an administrator"),
        }
    }
}

#[cfg(test)]
mod tests {
    use model::Role;

    use super::*;
    use crate::samples;

    #[test]
    fn pages_of_a_stranger_escape_what_the_provider_says() {
        let leave = LeavePage {
            provider: "North <b>".to_owned(),
            host: "login.example.edu".to_owned(),
            address: "https://login.example.edu/authorize?state=1&nonce=2".to_owned(),
        };
        assert!(samples::keep_page("sign-in-leave", &leave).contains("North &#60;b&#62;"));
        for reason in SignInRefusal::ALL {
            let html = SignInRefusedPage { reason }.render().unwrap();
            assert!(html.contains(reason.code()), "{html}");
        }
        samples::keep_page("sign-in-refused", &SignInRefusedPage { reason: SignInRefusal::NoFlow });
        let unknown = |creates| UnknownPersonPage {
            csrf: "c".to_owned(),
            provider: "North".to_owned(),
            name: "<i>Ana".to_owned(),
            email: "ana@example.edu".to_owned(),
            creates,
            error: None,
        };
        let html = samples::keep_page("sign-in-unknown", &unknown(true));
        assert!(html.contains("&#60;i&#62;Ana") && html.contains("/sign-in/begin"), "{html}");
        assert!(!unknown(false).render().unwrap().contains("/sign-in/begin"));
    }

    #[test]
    fn joined_accounts_are_listed_with_a_way_to_remove_them() {
        let row = |how| IdentityRow {
            provider: "North".to_owned(),
            subject: "00u1".to_owned(),
            how,
            made: samples::NOW,
            used: Some(samples::NOW),
            remove_href: "/account/identities/1/remove".to_owned(),
        };
        let origins =
            [IdentityOrigin::Created, IdentityOrigin::Matched, IdentityOrigin::Joined, IdentityOrigin::ByAdministrator];
        let page = IdentitiesPage {
            shell: samples::shell(Role::Trainee),
            rows: origins.map(row).to_vec(),
            providers: vec![ProviderChoice { id: ProviderId::nil(), name: "North".to_owned() }],
            next: "/account/tokens".to_owned(),
            refused: None,
        };
        let html = samples::keep_page("identities", &page);
        assert_eq!(html.matches("/account/identities/1/remove").count(), 4, "{html}");
        assert!(html.contains("/account/prove/") && html.contains("/account/identities/join/"), "{html}");
        let none = IdentitiesPage { shell: samples::shell(Role::Trainee), rows: vec![], ..page };
        assert!(!samples::keep_page("identities-none", &none).contains("/account/prove/"));
    }
}
