-- Processes that are at work on this database. Each counts its own beats: one whose count stands still is dead, whatever the clocks say.
CREATE TABLE replicas (
    id BLOB PRIMARY KEY CHECK (length(id) = 16),
    beats INTEGER NOT NULL DEFAULT 0 CHECK (beats >= 0)
) STRICT, WITHOUT ROWID;

-- What one of them does for all.
CREATE TABLE duties (
    name TEXT PRIMARY KEY,
    replica_id BLOB NOT NULL REFERENCES replicas (id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;

CREATE INDEX duties_by_replica ON duties (replica_id);

-- Who works on a recording. What was begun until now is tried anew.
ALTER TABLE jobs ADD COLUMN held_by BLOB REFERENCES replicas (id) ON DELETE SET NULL;
UPDATE jobs SET begun = 0 WHERE begun = 1;

CREATE INDEX jobs_by_holder ON jobs (held_by) WHERE held_by IS NOT NULL;

-- Who reads an upload that is whole.
ALTER TABLE uploads ADD COLUMN held_by BLOB REFERENCES replicas (id) ON DELETE SET NULL;
ALTER TABLE uploads DROP COLUMN begun;

CREATE INDEX uploads_by_holder ON uploads (held_by) WHERE held_by IS NOT NULL;

-- Who reads bytes that came at once.
CREATE TABLE readers (
    id BLOB PRIMARY KEY CHECK (length(id) = 16),
    reading_id BLOB NOT NULL REFERENCES readings (id) ON DELETE CASCADE,
    replica_id BLOB NOT NULL REFERENCES replicas (id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;

CREATE INDEX readers_by_reading ON readers (reading_id);
CREATE INDEX readers_by_replica ON readers (replica_id);

ALTER TABLE readings DROP COLUMN begun;

-- Tries to guess something, by a hash of who tries what, and until when they count.
CREATE TABLE brakes (
    key_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(key_sha256) = 32),
    until INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

CREATE INDEX brakes_by_time ON brakes (until);

-- What passkeys were asked and have not answered yet.
CREATE TABLE ceremonies (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    person_id BLOB NOT NULL REFERENCES people (id),
    until INTEGER NOT NULL,
    asked TEXT NOT NULL -- JSON
) STRICT, WITHOUT ROWID;

CREATE INDEX ceremonies_by_person ON ceremonies (person_id, until);
CREATE INDEX ceremonies_by_time ON ceremonies (until);
