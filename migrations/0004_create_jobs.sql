-- The durable queue: a job is deleted in the transaction that stores its outcome, so a crash repeats it.
CREATE TABLE jobs (
    school_id BLOB NOT NULL,
    session_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('score')),
    attempts INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER NOT NULL,
    error TEXT,
    PRIMARY KEY (school_id, session_id, kind),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
) STRICT;

CREATE INDEX jobs_by_time ON jobs (next_run_at);
