-- Bytes that came at once and are about to be read, by their hash: a try is written down before the file is touched. A row goes when its
-- reader has lived; one that was fatal twice is read no more.
CREATE TABLE readings (
    id BLOB NOT NULL UNIQUE CHECK (length(id) = 16),
    school_id BLOB NOT NULL REFERENCES schools (id),
    sha256 TEXT NOT NULL,
    begun INTEGER NOT NULL DEFAULT 0 CHECK (begun >= 0), -- readers at this moment
    deaths INTEGER NOT NULL DEFAULT 0,
    noted_at INTEGER NOT NULL,
    PRIMARY KEY (school_id, sha256)
) STRICT;

CREATE INDEX readings_by_time ON readings (noted_at);

-- The next job of each school: no school waits for the jobs of another.
CREATE INDEX jobs_by_school ON jobs (school_id, deaths, next_run_at, session_id);
