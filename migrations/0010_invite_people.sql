-- People who are invited, imported, looked up, disabled and made anonymous in the browser.
ALTER TABLE schools ADD COLUMN time_zone TEXT NOT NULL DEFAULT 'UTC'; -- a name of the IANA database
ALTER TABLE people ADD COLUMN registrar_id TEXT; -- what the registrar's system knows them by
ALTER TABLE people ADD COLUMN erased_at INTEGER; -- since when nothing here tells who they are
ALTER TABLE people ADD COLUMN search TEXT NOT NULL DEFAULT ''; -- name and address in lower case
UPDATE people SET search = lower(display_name) || ' ' || email;
CREATE UNIQUE INDEX people_by_registrar ON people (school_id, registrar_id) WHERE registrar_id IS NOT NULL;
CREATE INDEX people_by_name ON people (school_id, display_name, id);

-- Links that let somebody set their password, once. An empty password_hash fits no password.
CREATE TABLE account_links (
    token_sha256 BLOB PRIMARY KEY NOT NULL CHECK (length(token_sha256) = 32),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    purpose TEXT NOT NULL CHECK (purpose IN ('invitation', 'reset')),
    expires_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX account_links_by_person ON account_links (person_id);
CREATE INDEX account_links_by_expiry ON account_links (expires_at);

-- Rosters that were looked at and wait to be confirmed. A confirmed or old one is deleted: it holds names.
CREATE TABLE rosters (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    made_by BLOB NOT NULL,
    file_name TEXT NOT NULL,
    body BLOB NOT NULL,
    wanted TEXT NOT NULL, -- JSON
    made_at INTEGER NOT NULL,
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
) STRICT;

CREATE INDEX rosters_by_time ON rosters (made_at);

-- What is to be mailed. No body and no token: both are made when it is sent.
CREATE TABLE mails (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    person_id BLOB NOT NULL,
    kind TEXT NOT NULL CHECK (kind IN ('invitation', 'reset', 'reminder')),
    assignment_id BLOB, -- of a reminder
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER, -- absent: sent, or given up
    sent_at INTEGER,
    error TEXT,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((kind = 'reminder') = (assignment_id IS NOT NULL))
) STRICT;

CREATE INDEX mails_by_time ON mails (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX mails_by_person ON mails (school_id, person_id);
-- Each reminder once.
CREATE UNIQUE INDEX reminders_once ON mails (assignment_id, person_id) WHERE assignment_id IS NOT NULL;

-- What somebody did and what was done with their account, for their export.
CREATE INDEX audit_log_by_actor ON audit_log (actor);
CREATE INDEX audit_log_by_object ON audit_log (object);
