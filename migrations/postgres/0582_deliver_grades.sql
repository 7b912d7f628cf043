-- Grades for learning platforms: one row for each link and each of its users. What is sent is read from the grades when it is sent.
CREATE UNIQUE INDEX platform_links_by_school ON platform_links (school_id, id);

CREATE TABLE deliveries (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('ags')),
    platform_id UUID NOT NULL,
    link_id UUID NOT NULL, -- whose line item gets the grade
    person_id UUID NOT NULL,
    subject TEXT COLLATE "C" NOT NULL, -- the person, as the platform names them
    state TEXT COLLATE "C" NOT NULL CHECK (state IN ('waiting', 'idle', 'sent', 'stopped')),
    version BIGINT NOT NULL DEFAULT 0, -- grows whenever the grade may have changed
    tries BIGINT NOT NULL DEFAULT 0, -- since the last success or change
    next_run_at BIGINT,
    body TEXT COLLATE "C", -- JSON: what the platform has, without its timestamp; absent: nothing, or unknown
    stamped_at BIGINT, -- timestamp of the last message, which may not have arrived
    last_status BIGINT, -- of HTTP
    last_answer TEXT COLLATE "C" CHECK (length(last_answer) <= 500), -- of a platform that refused
    made_at BIGINT NOT NULL,
    sent_at BIGINT,
    UNIQUE (school_id, link_id, subject),
    CHECK ((state = 'waiting') = (next_run_at IS NOT NULL)),
    FOREIGN KEY (school_id, platform_id) REFERENCES platforms (school_id, id),
    FOREIGN KEY (school_id, link_id) REFERENCES platform_links (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE INDEX deliveries_due ON deliveries (school_id, platform_id, next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX deliveries_by_state ON deliveries (school_id, platform_id, state, id);
CREATE INDEX deliveries_by_person ON deliveries (school_id, person_id);

-- A notice may tell that a grade was refused.
ALTER TABLE notices DROP CONSTRAINT notices_kind_check;
ALTER TABLE notices ADD CONSTRAINT notices_kind_check CHECK (kind IN ('comment', 'question', 'answer', 'override', 'rating', 'assignment', 'delivery'));
