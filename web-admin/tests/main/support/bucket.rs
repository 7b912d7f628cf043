//! Buckets of a real store that speaks S3, one store for all tests, and each bucket one test's alone.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;

use platform::bucket_address::BucketAddress;
use platform::clock::Clock;
use platform::config::{Config, RecordingsPlace};
use tempfile::TempDir;
use uuid::Uuid;

use super::App;

/// The store. It ends when its standard input does, which is with this process, unless it is one that other processes share.
struct BucketServer {
    _child: Option<Child>,
    address: String,
}

static SERVER: LazyLock<BucketServer> = LazyLock::new(|| {
    if let Ok(address) = std::env::var("STYLET_TEST_BUCKETS") {
        return BucketServer { _child: None, address };
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let python = std::env::var("STYLET_TEST_PYTHON").unwrap_or_else(|_| "target/venv/bin/python".to_owned());
    let mut command = Command::new(root.join(python));
    command.arg(root.join("tests/python/serve_bucket.py")).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("deploy/test makes the environment of Python");
    let mut address = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let address = address.trim().strip_prefix("http://").expect("the store says where it is").to_owned();
    BucketServer { _child: Some(child), address }
});

/// How a bucket refuses.
#[derive(Clone, Copy, Debug)]
pub enum Refusal {
    /// What is asked is not done.
    Lost,
    /// It is done, and refused all the same.
    Unheard,
    /// There is no room.
    Full,
}

/// A bucket of one's own.
pub struct TestBucket {
    name: String,
}

impl TestBucket {
    pub fn new() -> Self {
        let bucket = Self { name: format!("school-{}", Uuid::new_v4()) };
        bucket.mend();
        bucket
    }

    /// As a command is told of it.
    pub fn url(&self) -> String {
        format!("s3://{}/north", self.name)
    }

    /// What a command's environment must say of it.
    pub fn environment(&self) -> BTreeMap<String, String> {
        let settings = [
            ("AWS_ENDPOINT", format!("http://{}", SERVER.address)),
            ("AWS_REGION", "us-east-1".to_owned()),
            ("AWS_ACCESS_KEY_ID", "test".to_owned()),
            ("AWS_SECRET_ACCESS_KEY", "test".to_owned()),
        ];
        settings.map(|(name, value)| (name.to_owned(), value)).into()
    }

    /// Has a configuration keep recordings in it.
    pub fn keep(&self, config: &mut Config) {
        let address = BucketAddress::parse(self.url().strip_prefix("s3://").unwrap(), self.environment()).unwrap();
        config.keep_recordings_in(RecordingsPlace::Bucket(address));
    }

    /// A service that keeps recordings in it.
    pub async fn app(&self) -> App {
        App::with(Clock::system(), |config| self.keep(config)).await
    }

    /// Another service on the same database, with nothing else of the first.
    pub async fn replica(&self, of: &App) -> App {
        let database = of.state.config.database.clone();
        App::in_folder(TempDir::new().unwrap(), Clock::system(), |config| {
            self.keep(config);
            config.database = database;
        })
        .await
    }

    /// Refuses from the nth request on.
    pub fn refuse(&self, how: Refusal, nth: usize) {
        let way = match how {
            Refusal::Lost => "lost",
            Refusal::Unheard => "unheard",
            Refusal::Full => "full",
        };
        self.tell(way, nth);
    }

    /// Refuses nothing any more; how many requests there were since it was told anything.
    pub fn mend(&self) -> usize {
        self.tell("lost", 0).parse().unwrap()
    }

    fn tell(&self, way: &str, nth: usize) -> String {
        exchange(&format!("GET /-/{}/{way}/{nth}", self.name), b"")
    }

    /// Puts an object beside those of the service, or in the place of one.
    pub fn put(&self, name: &str, bytes: &[u8]) {
        exchange(&format!("PUT /{}/north/{name}", self.name), bytes);
    }

    pub fn delete(&self, name: &str) {
        exchange(&format!("DELETE /{}/north/{name}", self.name), b"");
    }

    /// Names of all objects, but for what all of them begin with.
    pub fn names(&self) -> Vec<String> {
        let listed = exchange(&format!("GET /{}", self.name), b"");
        let keys = listed.split("<Key>north/").skip(1);
        keys.map(|rest| rest.split('<').next().unwrap().to_owned()).collect()
    }
}

/// Asks the store; the body of its answer.
fn exchange(request: &str, body: &[u8]) -> String {
    let mut stream = TcpStream::connect(&SERVER.address).unwrap();
    // The store wants to know who asks, and believes everybody.
    let who = "Authorization: AWS4-HMAC-SHA256 Credential=test/20260101/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0";
    let head = format!("{request} HTTP/1.1\r\nHost: {}\r\n{who}\r\nConnection: close", SERVER.address);
    stream.write_all(format!("{head}\r\nContent-Length: {}\r\n\r\n", body.len()).as_bytes()).unwrap();
    stream.write_all(body).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.split(' ').nth(1).unwrap().starts_with('2'), "{request}: {answer}");
    answer.split_once("\r\n\r\n").unwrap().1.to_owned()
}
