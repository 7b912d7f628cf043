-- Addresses by which a link to another password was asked for, whosever they are: looked up later, so that the answer's time
-- does not tell whether somebody has them.
CREATE TABLE asked_links (
    email TEXT PRIMARY KEY NOT NULL CHECK (length(email) <= 254),
    asked_at INTEGER NOT NULL -- µs since 1970, UTC
) STRICT;

CREATE INDEX asked_links_by_time ON asked_links (asked_at, email);

-- What ends with an account, and what is erased with it.
CREATE INDEX recording_links_by_maker ON recording_links (made_by);
CREATE INDEX survey_letters_by_address ON survey_letters (school_id, email);
