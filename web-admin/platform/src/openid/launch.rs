//! Third-party initiated login of a learning platform (1EdTech Security Framework 1.0, section 5.1.1).

use url::Url;

/// A request to the authorization endpoint of a learning platform.
#[derive(Clone, Copy, Debug)]
pub struct LaunchRequest<'a> {
    /// Id of this service at the platform.
    pub client_id: &'a str,
    /// Address to which the browser posts the ID token.
    pub redirect_uri: &'a str,
    /// The user, as the platform has named them.
    pub login_hint: &'a str,
    /// The message, as the platform has named it.
    pub message_hint: Option<&'a str>,
    /// Ties the answer to the launch.
    pub state: &'a str,
    /// Ties the ID token to the launch.
    pub nonce: &'a str,
}

impl LaunchRequest<'_> {
    /// Returns the address to which the browser is sent.
    #[must_use]
    pub fn address(&self, endpoint: &Url) -> Url {
        let mut url = endpoint.clone();
        let mut query = url.query_pairs_mut();
        query
            .append_pair("scope", "openid")
            .append_pair("response_type", "id_token")
            .append_pair("response_mode", "form_post")
            .append_pair("prompt", "none")
            .append_pair("client_id", self.client_id)
            .append_pair("redirect_uri", self.redirect_uri)
            .append_pair("login_hint", self.login_hint)
            .append_pair("state", self.state)
            .append_pair("nonce", self.nonce);
        if let Some(hint) = self.message_hint {
            query.append_pair("lti_message_hint", hint);
        }
        drop(query);
        url
    }
}
