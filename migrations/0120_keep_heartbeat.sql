-- What is written to find out whether anything can be: one row.
CREATE TABLE heartbeat (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    beaten_at INTEGER NOT NULL -- µs since 1970, UTC
) STRICT;

INSERT INTO heartbeat (id, beaten_at) VALUES (1, 0);
