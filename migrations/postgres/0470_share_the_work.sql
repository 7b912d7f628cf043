-- Processes that are at work on this database. Each counts its own beats: one whose count stands still is dead, whatever the clocks say.
CREATE TABLE replicas (
    id UUID PRIMARY KEY,
    beats BIGINT NOT NULL DEFAULT 0 CHECK (beats >= 0)
);

-- What one of them does for all.
CREATE TABLE duties (
    name TEXT COLLATE "C" PRIMARY KEY,
    replica_id UUID NOT NULL REFERENCES replicas (id) ON DELETE CASCADE
);

CREATE INDEX duties_by_replica ON duties (replica_id);

-- Who works on a recording. What was begun until now is tried anew.
ALTER TABLE jobs ADD COLUMN held_by UUID REFERENCES replicas (id) ON DELETE SET NULL;
UPDATE jobs SET begun = FALSE WHERE begun;

CREATE INDEX jobs_by_holder ON jobs (held_by) WHERE held_by IS NOT NULL;

-- Who reads an upload that is whole.
ALTER TABLE uploads ADD COLUMN held_by UUID REFERENCES replicas (id) ON DELETE SET NULL;
ALTER TABLE uploads DROP COLUMN begun;

CREATE INDEX uploads_by_holder ON uploads (held_by) WHERE held_by IS NOT NULL;

-- Who reads bytes that came at once.
CREATE TABLE readers (
    id UUID PRIMARY KEY,
    reading_id UUID NOT NULL REFERENCES readings (id) ON DELETE CASCADE,
    replica_id UUID NOT NULL REFERENCES replicas (id) ON DELETE CASCADE
);

CREATE INDEX readers_by_reading ON readers (reading_id);
CREATE INDEX readers_by_replica ON readers (replica_id);

ALTER TABLE readings DROP COLUMN begun;

-- Tries to guess something, by a hash of who tries what, and until when they count.
CREATE TABLE brakes (
    key_sha256 BYTEA PRIMARY KEY CHECK (length(key_sha256) = 32),
    until BIGINT NOT NULL
);

CREATE INDEX brakes_by_time ON brakes (until);

-- What passkeys were asked and have not answered yet.
CREATE TABLE ceremonies (
    id UUID PRIMARY KEY,
    person_id UUID NOT NULL REFERENCES people (id),
    until BIGINT NOT NULL,
    asked TEXT COLLATE "C" NOT NULL -- JSON
);

CREATE INDEX ceremonies_by_person ON ceremonies (person_id, until);
CREATE INDEX ceremonies_by_time ON ceremonies (until);
