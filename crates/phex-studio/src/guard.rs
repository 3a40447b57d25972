//! Who may ask: this machine, by the printed address.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// What the page may load: what comes from this server, and nothing from anywhere else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The names by which this server may be called.
pub struct OwnNames([String; 2]);

impl OwnNames {
    /// Those of a port.
    pub fn new(port: u16) -> Arc<Self> {
        Arc::new(Self([
            format!("127.0.0.1:{port}"),
            format!("localhost:{port}"),
        ]))
    }

    /// Whether a request is for this server, and not from a page of another. A name that leads here
    /// by a trick (DNS rebinding) is a foreign one.
    fn admits(&self, headers: &HeaderMap) -> bool {
        let text = |name| headers.get(name).map(HeaderValue::to_str);
        let host = text(header::HOST).and_then(Result::ok);
        let called = host.is_some_and(|host| self.0.iter().any(|own| own == host));
        let from_here = match text(header::ORIGIN) {
            None => true,
            Some(origin) => origin
                .is_ok_and(|origin| self.0.iter().any(|own| origin == format!("http://{own}"))),
        };
        called && from_here
    }
}

/// Refuses what is not for this server, and tells the browser to keep answers to itself.
pub async fn guard(State(own): State<Arc<OwnNames>>, request: Request, next: Next) -> Response {
    let mut response = match own.admits(request.headers()) {
        true => next.run(request).await,
        false => StatusCode::FORBIDDEN.into_response(),
    };
    let headers = [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    for (name, value) in headers {
        let value = HeaderValue::from_static(value);
        response.headers_mut().insert(name, value);
    }
    response
}
