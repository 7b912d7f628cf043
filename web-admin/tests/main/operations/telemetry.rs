//! Spans and figures at a collector, read by OpenTelemetry's own definitions of its messages.
//!
//! Fails when nothing arrives, when a span tells whom a request was about, when a figure of `/metrics` is not sent, or when a collector that is
//! not there keeps the service from serving.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::routing::post;
use opentelemetry_proto::tonic::collector::metrics::v1::ExportMetricsServiceRequest;
use opentelemetry_proto::tonic::collector::trace::v1::ExportTraceServiceRequest;
use opentelemetry_proto::tonic::trace::v1::Span;
use prost::Message;
use tempfile::TempDir;

use crate::support::database::program;
use crate::support::service::Service;

/// What has arrived.
#[derive(Clone, Default)]
struct Collector {
    spans: Arc<Mutex<Vec<Span>>>,
    metrics: Arc<Mutex<BTreeSet<String>>>,
}

impl Collector {
    /// Listens; its address.
    async fn listen(&self) -> String {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("http://{}", listener.local_addr().unwrap());
        let routes = Router::new().route("/v1/traces", post(take_spans)).route("/v1/metrics", post(take_metrics));
        let routes = routes.with_state(self.clone());
        tokio::spawn(async move { axum::serve(listener, routes).await.unwrap() });
        address
    }
}

async fn take_spans(State(collector): State<Collector>, body: Bytes) {
    let sent = ExportTraceServiceRequest::decode(body).unwrap();
    let scopes = sent.resource_spans.into_iter().flat_map(|resource| resource.scope_spans);
    collector.spans.lock().unwrap().extend(scopes.flat_map(|scope| scope.spans));
}

async fn take_metrics(State(collector): State<Collector>, body: Bytes) {
    let sent = ExportMetricsServiceRequest::decode(body).unwrap();
    let scopes = sent.resource_metrics.into_iter().flat_map(|resource| resource.scope_metrics);
    collector.metrics.lock().unwrap().extend(scopes.flat_map(|scope| scope.metrics).map(|metric| metric.name));
}

#[tokio::test(flavor = "multi_thread")]
async fn spans_and_figures_reach_a_collector_and_name_nobody() {
    const WHOSE: &str = "01a21b2e-ada6-74ce-8283-38a64a6384df";
    let collector = Collector::default();
    let address = collector.listen().await;
    let folder = TempDir::new().unwrap();
    let service = Service::start_with(
        folder.path(),
        &[
            ("OTEL_EXPORTER_OTLP_ENDPOINT", Path::new(&address)),
            ("OTEL_METRIC_EXPORT_INTERVAL", Path::new("200")),
            ("OTEL_BSP_SCHEDULE_DELAY", Path::new("200")),
        ],
    );
    assert_eq!(service.get("/login").0, 200);
    assert_ne!(service.get(&format!("/sessions/{WHOSE}/replay?at=3")).0, 200);
    let shown = service.get("/metrics").1;
    let shown: BTreeSet<&str> =
        shown.lines().filter_map(|line| line.strip_prefix("# TYPE ")?.split(' ').next()).collect();
    assert!(shown.len() > 10, "{shown:?}");
    let wanted = ["GET /login", "GET /sessions/{id}/replay"];
    let has_all = || {
        let (spans, metrics) = (collector.spans.lock().unwrap(), collector.metrics.lock().unwrap());
        wanted.iter().all(|name| spans.iter().any(|span| span.name == *name))
            && shown.iter().all(|family| metrics.iter().any(|name| name.starts_with(family)))
    };
    for _ in 0..150 {
        if has_all() {
            break;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    let spans = collector.spans.lock().unwrap();
    let names: BTreeSet<&str> = spans.iter().map(|span| span.name.as_str()).collect();
    let metrics = collector.metrics.lock().unwrap();
    assert!(wanted.iter().all(|name| names.contains(name)), "{names:?}");
    assert!(shown.iter().all(|family| metrics.iter().any(|name| name.starts_with(family))), "{metrics:?}");
    assert!(!format!("{spans:?}").contains(WHOSE), "{spans:?}");
}

#[test]
fn missing_collector_is_tolerated_and_an_invalid_address_named() {
    const NAME: &str = "OTEL_EXPORTER_OTLP_ENDPOINT";
    let folder = TempDir::new().unwrap();
    let service = Service::start_with(folder.path(), &[(NAME, Path::new("http://127.0.0.1:9"))]);
    assert_eq!(service.get("/readyz"), (200, "ready\n".to_owned()));
    drop(service);
    let refused = program(folder.path()).arg("serve").env(NAME, "no address").output().unwrap();
    let words = String::from_utf8(refused.stderr).unwrap();
    assert!(!refused.status.success() && words.contains(NAME) && words.contains("no address"), "{words}");
}
