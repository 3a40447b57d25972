//! The body of a request, in time and up to a size.

use axum::body::Body;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::json;
use std::time::Duration;
use tokio_stream::StreamExt;

/// Largest file that may be dropped, in bytes.
pub const MOST_BYTES: usize = 256 << 20;
/// Largest request besides, in bytes: guides drawn by hand are far below.
pub const MOST_OF_A_REQUEST: usize = 4 << 20;
/// How long a sender may be silent.
const PATIENCE: Duration = Duration::from_secs(20);

/// Why a request has no answer.
pub struct RefusedRequest {
    status: StatusCode,
    message: String,
}

impl RefusedRequest {
    /// A file or value that can't be used, in the words of its reader.
    pub fn unusable(message: impl std::fmt::Display) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, message)
    }

    /// Something that is not there any more.
    pub fn gone(message: &str) -> Self {
        Self::new(StatusCode::GONE, message)
    }

    /// Something that should not happen.
    pub fn internal(message: impl std::fmt::Display) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, message)
    }

    fn new(status: StatusCode, message: impl std::fmt::Display) -> Self {
        let message = message.to_string();
        Self { status, message }
    }
}

impl IntoResponse for RefusedRequest {
    fn into_response(self) -> Response {
        let message = json!({ "message": self.message });
        (self.status, axum::Json(message)).into_response()
    }
}

/// The bytes of a body.
///
/// # Errors
/// If there are more than `most`, the sender is silent for long, or goes away.
pub async fn whole(body: Body, most: usize) -> Result<Vec<u8>, RefusedRequest> {
    let stream = body.into_data_stream().timeout(PATIENCE);
    tokio::pin!(stream);
    let mut bytes = Vec::new();
    while let Some(part) = stream.next().await {
        let silent = |_| {
            let message = "the sender was silent for 20 seconds";
            RefusedRequest::new(StatusCode::REQUEST_TIMEOUT, message)
        };
        let broken = |e| {
            RefusedRequest::new(
                StatusCode::BAD_REQUEST,
                format!("the upload broke off: {e}"),
            )
        };
        let part = part.map_err(silent)?.map_err(broken)?;
        if bytes.len() + part.len() > most {
            let message = format!("more than {} MB are not taken", most >> 20);
            return Err(RefusedRequest::new(StatusCode::PAYLOAD_TOO_LARGE, message));
        }
        bytes.extend_from_slice(&part);
    }
    Ok(bytes)
}
