//! Spans and figures, sent to a collector that the environment names.

use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use acts::SPANS;
use acts::error::tell_in_full;
use anyhow::Context;
use opentelemetry::KeyValue;
use opentelemetry::metrics::{AsyncInstrument, Meter, MeterProvider};
use opentelemetry::trace::TracerProvider;
use opentelemetry_otlp::{MetricExporter, Protocol, SpanExporter, WithExportConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::metrics::SdkMeterProvider;
use opentelemetry_sdk::trace::SdkTracerProvider;
use routes_base::monitoring::{MetricFamily, MetricFigure, MetricKind};
use tracing::Subscriber;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::filter_fn;
use tracing_subscriber::registry::LookupSpan;

use super::name_collectors;
use crate::AppState;
use crate::routes::health::list_families;

/// What the program is called where `OTEL_SERVICE_NAME` does not say.
const NAME: &str = "web-admin";
/// How often the figures are taken; they are sent every minute, unless `OTEL_METRIC_EXPORT_INTERVAL` says otherwise.
const FIGURES_EVERY: Duration = Duration::from_secs(10);

/// What sends spans and figures.
pub(crate) struct Telemetry {
    spans: SdkTracerProvider,
    figures: SdkMeterProvider,
}

impl Telemetry {
    /// To the collector that the environment names; none where it names none.
    ///
    /// # Errors
    /// When a variable makes no sense.
    pub(crate) fn of_environment() -> anyhow::Result<Option<Self>> {
        let named = name_collectors();
        if named.is_empty() {
            return Ok(None);
        }
        acts::settle_tls();
        let which = || format!("{}: allowed is the address of a collector, as http://collector:4318", named.join(", "));
        let spans = SpanExporter::builder().with_http().with_protocol(Protocol::HttpBinary).build();
        let figures = MetricExporter::builder().with_http().with_protocol(Protocol::HttpBinary).build();
        let resource = resource();
        Ok(Some(Self {
            spans: SdkTracerProvider::builder()
                .with_resource(resource.clone())
                .with_batch_exporter(spans.with_context(which)?)
                .build(),
            figures: SdkMeterProvider::builder()
                .with_resource(resource)
                .with_periodic_exporter(figures.with_context(which)?)
                .build(),
        }))
    }

    /// What hands the program's spans on.
    pub(crate) fn layer<S: Subscriber + for<'span> LookupSpan<'span>>(&self) -> impl Layer<S> + use<S> {
        let spans = filter_fn(|metadata| metadata.is_span() && metadata.target() == SPANS);
        tracing_opentelemetry::layer().with_tracer(self.spans.tracer(NAME)).with_filter(spans)
    }

    /// Takes the figures of `/metrics` again and again, for as long as this is awaited.
    pub(crate) fn send_figures(&self, state: AppState) -> impl Future<Output = ()> + Send + use<> {
        let meter = self.figures.meter(NAME);
        async move {
            let latest: Arc<RwLock<Vec<MetricFamily>>> = Arc::default();
            let mut are_known = false;
            let mut ticks = tokio::time::interval(FIGURES_EVERY);
            loop {
                ticks.tick().await;
                match list_families(&state).await {
                    Ok(families) => *latest.write().unwrap_or_else(PoisonError::into_inner) = families,
                    Err(error) => {
                        tracing::warn!(cause = tell_in_full(&error), "the figures of the service cannot be taken")
                    }
                }
                are_known = are_known || register_families(&meter, &latest);
            }
        }
    }

    /// Sends what is still to be sent. Blocks.
    pub(crate) fn end(self) {
        for (what, ended) in [("spans", self.spans.shutdown()), ("figures", self.figures.shutdown())] {
            if let Err(error) = ended {
                tracing::warn!(cause = tell_in_full(&error), "the last {what} were not sent");
            }
        }
    }
}

/// Who sends.
fn resource() -> Resource {
    let builder = match std::env::var("OTEL_SERVICE_NAME") {
        Ok(name) if !name.is_empty() => Resource::builder(),
        _ => Resource::builder().with_service_name(NAME),
    };
    builder.with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION"))).build()
}

/// Makes an instrument of each kind of figure that there is; whether there are any.
fn register_families(meter: &Meter, latest: &Arc<RwLock<Vec<MetricFamily>>>) -> bool {
    let families = latest.read().unwrap_or_else(PoisonError::into_inner);
    for family in families.iter() {
        let mut suffixes: Vec<&'static str> = family.figures.iter().map(|figure| figure.suffix).collect();
        suffixes.dedup();
        for suffix in suffixes {
            let (name, latest) = (family.name, Arc::clone(latest));
            let observe = move |to: &dyn AsyncInstrument<f64>| {
                let families = latest.read().unwrap_or_else(PoisonError::into_inner);
                let own = families.iter().filter(|family| family.name == name).flat_map(|family| &family.figures);
                own.filter(|figure| figure.suffix == suffix)
                    .for_each(|figure| to.observe(figure.value, &labels(figure)));
            };
            let full_name = format!("{name}{suffix}");
            match family.kind {
                MetricKind::Gauge => {
                    let gauge = meter.f64_observable_gauge(full_name).with_description(family.help);
                    gauge.with_callback(observe).build();
                }
                MetricKind::Counter | MetricKind::Histogram => {
                    let counter = meter.f64_observable_counter(full_name).with_description(family.help);
                    counter.with_callback(observe).build();
                }
            }
        }
    }
    !families.is_empty()
}

fn labels(figure: &MetricFigure) -> Vec<KeyValue> {
    figure.label.iter().map(|(name, value)| KeyValue::new(*name, value.clone())).collect()
}
