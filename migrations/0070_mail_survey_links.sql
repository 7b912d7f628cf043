-- Links of surveys that are mailed to people without an account. A link is made when its letter goes out, so none lies here.
CREATE TABLE survey_letters (
    id BLOB PRIMARY KEY NOT NULL CHECK (length(id) = 16),
    school_id BLOB NOT NULL,
    survey_id BLOB NOT NULL,
    name TEXT NOT NULL,
    email TEXT NOT NULL,
    response_id BLOB, -- the link it holds; absent once it is out: then nothing leads from an address to an answer
    tries INTEGER NOT NULL DEFAULT 0,
    next_run_at INTEGER, -- absent: sent, given up, or on its way when the service ended
    sent_at INTEGER,
    error TEXT,
    UNIQUE (survey_id, email), -- nobody is written to twice
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, response_id) REFERENCES survey_responses (school_id, id)
) STRICT;

CREATE INDEX survey_letters_by_time ON survey_letters (next_run_at) WHERE next_run_at IS NOT NULL;
