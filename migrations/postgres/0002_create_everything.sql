-- What SQLite's migrations come to, up to 0450. Ids are UUIDs, truth values BOOLEAN, and texts compare byte by byte, as SQLite's do.
-- Where a statement asks for the order in which rows came, `rowid` says it.

CREATE TABLE schools (
    id UUID PRIMARY KEY,
    name TEXT COLLATE "C" NOT NULL UNIQUE,
    created_at BIGINT NOT NULL, -- µs since 1970 UTC, as every *_at
    time_zone TEXT COLLATE "C" NOT NULL DEFAULT 'UTC',
    certificate_needs TEXT COLLATE "C" NOT NULL DEFAULT 'signed_or_supervised'
        CHECK (certificate_needs IN ('nothing', 'resimulated', 'signed_or_supervised', 'supervised')),
    erase_recordings BOOLEAN NOT NULL DEFAULT FALSE,
    retention_months BIGINT CHECK (retention_months BETWEEN 3 AND 240),
    retention_warn_days BIGINT NOT NULL DEFAULT 30 CHECK (retention_warn_days BETWEEN 7 AND 365),
    retention_texts BOOLEAN NOT NULL DEFAULT FALSE,
    second_factor_of TEXT COLLATE "C" NOT NULL DEFAULT 'nobody' CHECK (second_factor_of IN ('nobody', 'teachers', 'everybody')),
    letter_language TEXT COLLATE "C",
    mails_reminders BOOLEAN NOT NULL DEFAULT TRUE,
    mails_news BOOLEAN NOT NULL DEFAULT TRUE,
    shows_others BOOLEAN NOT NULL DEFAULT TRUE
);

CREATE TABLE people (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    email TEXT COLLATE "C" NOT NULL UNIQUE CHECK (email = lower(email)),
    display_name TEXT COLLATE "C" NOT NULL,
    pseudonym TEXT COLLATE "C" NOT NULL, -- what recordings say instead of a name
    password_hash TEXT COLLATE "C" NOT NULL,
    credential_version BIGINT NOT NULL DEFAULT 1, -- grows with each new password and ends older sign-ins
    disabled_at BIGINT,
    created_at BIGINT NOT NULL,
    registrar_id TEXT COLLATE "C",
    erased_at BIGINT,
    search TEXT COLLATE "C" NOT NULL DEFAULT '',
    language TEXT COLLATE "C" CHECK (length(language) BETWEEN 2 AND 16),
    held_at BIGINT,
    password_initial_until BIGINT,
    role TEXT COLLATE "C" NOT NULL DEFAULT 'trainee' CHECK (role IN ('trainee', 'instructor', 'administrator', 'guest')),
    mail_news BOOLEAN NOT NULL DEFAULT TRUE,
    sort_name TEXT COLLATE "C" NOT NULL DEFAULT '',
    sort_number TEXT COLLATE "C" GENERATED ALWAYS AS (coalesce(registrar_id, '')) STORED,
    UNIQUE (school_id, id),
    UNIQUE (school_id, pseudonym)
);
CREATE UNIQUE INDEX people_by_registrar ON people (school_id, registrar_id) WHERE registrar_id IS NOT NULL;
CREATE INDEX people_by_name ON people (school_id, display_name, id);
CREATE INDEX people_held ON people (school_id, held_at) WHERE held_at IS NOT NULL;
CREATE INDEX people_by_role ON people (school_id, role) WHERE disabled_at IS NULL;
CREATE INDEX people_who_teach ON people (school_id, display_name, id)
WHERE role = 'instructor' AND disabled_at IS NULL AND erased_at IS NULL;
CREATE INDEX people_by_sort_name ON people (school_id, sort_name, id);
CREATE INDEX people_by_address ON people (school_id, email, id);
CREATE INDEX people_by_number ON people (school_id, sort_number, id);
CREATE INDEX people_unsorted ON people (id) WHERE sort_name = '' AND role <> 'guest';

CREATE TABLE cohorts (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    name TEXT COLLATE "C" NOT NULL,
    created_at BIGINT NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, name)
);

CREATE TABLE cohort_members (
    school_id UUID NOT NULL,
    cohort_id UUID NOT NULL,
    person_id UUID NOT NULL,
    role TEXT COLLATE "C" NOT NULL CHECK (role IN ('instructor', 'trainee')),
    PRIMARY KEY (cohort_id, person_id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);
CREATE INDEX cohort_members_by_person ON cohort_members (person_id, role, cohort_id);

CREATE TABLE exercise_revisions (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    exercise_id TEXT COLLATE "C" NOT NULL,
    title TEXT COLLATE "C" NOT NULL,
    difficulty BIGINT NOT NULL,
    pass_mark DOUBLE PRECISION NOT NULL, -- 0–100
    exercise_sha256 TEXT COLLATE "C" NOT NULL,
    scene_sha256 TEXT COLLATE "C" NOT NULL,
    bundle_sha256 TEXT COLLATE "C" NOT NULL, -- over the exercise, its scene and every mesh
    exercise_bytes BYTEA NOT NULL,
    scene_bytes BYTEA NOT NULL,
    published_at BIGINT NOT NULL,
    rowid BIGINT GENERATED ALWAYS AS IDENTITY, -- in the order of arrival
    UNIQUE (school_id, id),
    UNIQUE (school_id, bundle_sha256)
);
CREATE INDEX exercise_revisions_by_sha ON exercise_revisions (school_id, exercise_sha256, scene_sha256);
CREATE INDEX exercise_revisions_by_exercise ON exercise_revisions (school_id, exercise_id, published_at);

CREATE TABLE exercise_meshes (
    revision_id UUID NOT NULL REFERENCES exercise_revisions (id),
    position BIGINT NOT NULL,
    name TEXT COLLATE "C" NOT NULL,
    bytes BYTEA NOT NULL,
    PRIMARY KEY (revision_id, position)
);

CREATE TABLE exercises (
    school_id UUID NOT NULL REFERENCES schools (id),
    exercise_id TEXT COLLATE "C" NOT NULL,
    revision_id UUID NOT NULL,
    PRIMARY KEY (school_id, exercise_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id)
);

CREATE TABLE curriculum_revisions (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    curriculum_id TEXT COLLATE "C" NOT NULL,
    title TEXT COLLATE "C" NOT NULL,
    description TEXT COLLATE "C" NOT NULL,
    mastery_passes BIGINT NOT NULL, -- passes of the last `mastery_of` attempts
    mastery_of BIGINT NOT NULL,
    sha256 TEXT COLLATE "C" NOT NULL,
    bytes BYTEA NOT NULL,
    published_at BIGINT NOT NULL,
    mastery_curve TEXT COLLATE "C",
    rowid BIGINT GENERATED ALWAYS AS IDENTITY, -- in the order of arrival
    UNIQUE (school_id, id),
    UNIQUE (school_id, sha256)
);
CREATE INDEX curriculum_revisions_by_curriculum ON curriculum_revisions (school_id, curriculum_id, published_at);

CREATE TABLE curriculum_entries (
    revision_id UUID NOT NULL REFERENCES curriculum_revisions (id),
    position BIGINT NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    prerequisites TEXT COLLATE "C" NOT NULL, -- JSON: array of exercise ids
    survey TEXT COLLATE "C",
    PRIMARY KEY (revision_id, position)
);

CREATE TABLE curricula (
    school_id UUID NOT NULL REFERENCES schools (id),
    curriculum_id TEXT COLLATE "C" NOT NULL,
    revision_id UUID NOT NULL,
    PRIMARY KEY (school_id, curriculum_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES curriculum_revisions (school_id, id)
);

CREATE TABLE sessions (
    school_id UUID NOT NULL REFERENCES schools (id),
    id UUID NOT NULL,
    trainee_id UUID NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    exercise_sha256 TEXT COLLATE "C" NOT NULL,
    scene_sha256 TEXT COLLATE "C" NOT NULL,
    revision_id UUID, -- absent: the recording carries an exercise that this school never published
    started_at BIGINT NOT NULL,
    received_at BIGINT NOT NULL,
    duration_s DOUBLE PRECISION NOT NULL,
    complete BOOLEAN NOT NULL, -- 0: the recording was cut
    device TEXT COLLATE "C" NOT NULL,
    simulator_version TEXT COLLATE "C" NOT NULL,
    seed TEXT COLLATE "C" NOT NULL, -- unsigned 64-bit, in decimal
    state TEXT COLLATE "C" NOT NULL CHECK (state IN ('pending', 'scored', 'refused')),
    refusal TEXT COLLATE "C",
    recording_path TEXT COLLATE "C" NOT NULL, -- relative to the recordings folder
    recording_sha256 TEXT COLLATE "C" NOT NULL,
    recording_size BIGINT NOT NULL, -- bytes
    verify_deviation_n DOUBLE PRECISION, -- largest, of the server's re-simulation
    verify_event_differences BIGINT,
    verify_flagged BOOLEAN,
    reviewed BOOLEAN NOT NULL DEFAULT FALSE,
    uncounted TEXT COLLATE "C" CHECK (uncounted IN ('unpublished', 'duplicate')),
    motion_sha256 TEXT COLLATE "C",
    repeats UUID,
    claimed_started_at BIGINT,
    signed_by UUID,
    recording_erased_at BIGINT,
    review_rank BIGINT NOT NULL DEFAULT 0 CHECK (review_rank BETWEEN 0 AND 7),
    rowid BIGINT GENERATED ALWAYS AS IDENTITY, -- in the order of arrival
    PRIMARY KEY (school_id, id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id)
);
CREATE INDEX sessions_by_trainee ON sessions (school_id, trainee_id, exercise_id, started_at);
CREATE INDEX sessions_by_trainee_and_time ON sessions (school_id, trainee_id, started_at);
CREATE INDEX sessions_by_time ON sessions (school_id, started_at);
CREATE INDEX sessions_by_exercise ON sessions (school_id, exercise_id, started_at);
CREATE INDEX sessions_flagged ON sessions (school_id) WHERE verify_flagged;
CREATE INDEX sessions_refused ON sessions (school_id) WHERE state = 'refused';
CREATE INDEX sessions_pending ON sessions (school_id) WHERE state = 'pending';
CREATE UNIQUE INDEX sessions_by_motion ON sessions (school_id, motion_sha256) WHERE motion_sha256 IS NOT NULL AND uncounted IS NULL;
CREATE INDEX sessions_uncounted ON sessions (school_id) WHERE uncounted IS NOT NULL;
CREATE INDEX sessions_without_recording ON sessions (recording_erased_at) WHERE recording_erased_at IS NOT NULL;
CREATE INDEX sessions_to_review ON sessions (school_id, review_rank, started_at, id) WHERE state = 'scored' AND NOT reviewed;
CREATE INDEX sessions_to_review_by_trainee ON sessions (school_id, trainee_id, review_rank, started_at, id)
WHERE state = 'scored' AND NOT reviewed;
CREATE INDEX sessions_to_review_at ON sessions (school_id, exercise_id, review_rank, started_at, id)
WHERE state = 'scored' AND NOT reviewed;

CREATE TABLE metrics (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    id TEXT COLLATE "C" NOT NULL,
    version BIGINT NOT NULL,
    position BIGINT NOT NULL, -- in the catalogue's order
    value DOUBLE PRECISION, -- absent outside the metric's domain
    unit TEXT COLLATE "C" NOT NULL,
    direction TEXT COLLATE "C" NOT NULL CHECK (direction IN ('lower', 'higher', 'range')),
    applies BOOLEAN NOT NULL,
    label TEXT COLLATE "C" NOT NULL,
    absent TEXT COLLATE "C" NOT NULL, -- why the metric does not apply; empty where it does
    PRIMARY KEY (school_id, session_id, id, version),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);

CREATE TABLE scores (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    score DOUBLE PRECISION NOT NULL, -- 0–100
    passed BOOLEAN NOT NULL,
    rubric_id TEXT COLLATE "C" NOT NULL,
    rubric_sha256 TEXT COLLATE "C" NOT NULL,
    deductions TEXT COLLATE "C" NOT NULL, -- JSON
    hard_fails TEXT COLLATE "C" NOT NULL, -- JSON
    simulator_version TEXT COLLATE "C" NOT NULL,
    computed_at BIGINT NOT NULL,
    rowid BIGINT GENERATED ALWAYS AS IDENTITY, -- in the order of arrival
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);
CREATE INDEX scores_by_session ON scores (school_id, session_id, computed_at, id);

CREATE TABLE session_curves (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    body TEXT COLLATE "C" NOT NULL, -- JSON
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);

CREATE TABLE jobs (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('score')),
    attempts BIGINT NOT NULL DEFAULT 0,
    next_run_at BIGINT NOT NULL,
    error TEXT COLLATE "C",
    begun BOOLEAN NOT NULL DEFAULT FALSE,
    deaths BIGINT NOT NULL DEFAULT 0,
    PRIMARY KEY (school_id, session_id, kind),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);
CREATE INDEX jobs_by_time ON jobs (next_run_at);
CREATE INDEX jobs_by_school ON jobs (school_id, deaths, next_run_at, session_id);

CREATE TABLE api_tokens (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    person_id UUID, -- a person's token, or
    station TEXT COLLATE "C", -- a station's, which uploads for whoever the recording names
    token_sha256 BYTEA NOT NULL UNIQUE CHECK (length(token_sha256) = 32),
    created_at BIGINT NOT NULL,
    revoked_at BIGINT,
    last_seen_at BIGINT,
    wrong_codes BIGINT NOT NULL DEFAULT 0,
    wrong_since BIGINT,
    public_key TEXT COLLATE "C",
    name TEXT COLLATE "C",
    expires_at BIGINT,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((person_id IS NULL) <> (station IS NULL))
);
CREATE UNIQUE INDEX api_tokens_by_school ON api_tokens (school_id, id);
CREATE UNIQUE INDEX stations_by_name ON api_tokens (school_id, station) WHERE revoked_at IS NULL;
CREATE INDEX api_tokens_by_person ON api_tokens (person_id) WHERE person_id IS NOT NULL;

CREATE TABLE web_sessions (
    id_sha256 BYTEA PRIMARY KEY CHECK (length(id_sha256) = 32),
    data TEXT COLLATE "C" NOT NULL, -- JSON
    expires_at BIGINT NOT NULL
);
CREATE INDEX web_sessions_by_expiry ON web_sessions (expires_at);

CREATE TABLE audit_log (
    seq BIGINT PRIMARY KEY,
    at BIGINT NOT NULL,
    school_id UUID,
    actor TEXT COLLATE "C" NOT NULL, -- a person's id, or 'command line', or 'worker'
    action TEXT COLLATE "C" NOT NULL,
    object TEXT COLLATE "C" NOT NULL,
    details TEXT COLLATE "C" NOT NULL, -- JSON
    prev_hash BYTEA NOT NULL CHECK (length(prev_hash) = 32),
    hash BYTEA NOT NULL CHECK (length(hash) = 32)
);
CREATE INDEX audit_log_by_actor ON audit_log (actor);
CREATE INDEX audit_log_by_object ON audit_log (object);
CREATE INDEX audit_log_by_school ON audit_log (school_id, seq);

CREATE TABLE uploads (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    person_id UUID, -- begun with a person's token, or
    station_id UUID, -- with a station's
    length BIGINT NOT NULL, -- bytes in all
    received BIGINT NOT NULL DEFAULT 0,
    metadata TEXT COLLATE "C" NOT NULL, -- Upload-Metadata as it was sent
    expires_at BIGINT NOT NULL,
    session_id UUID,
    clock_offset_us BIGINT,
    begun BOOLEAN NOT NULL DEFAULT FALSE,
    deaths BIGINT NOT NULL DEFAULT 0, -- the attempt it has become
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, station_id) REFERENCES api_tokens (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    CHECK ((person_id IS NULL) <> (station_id IS NULL)),
    CHECK (received BETWEEN 0 AND length),
    CHECK (session_id IS NULL OR received = length)
);
CREATE INDEX uploads_by_expiry ON uploads (expires_at);

CREATE TABLE pairing_codes (
    code_sha256 BYTEA PRIMARY KEY CHECK (length(code_sha256) = 32),
    school_id UUID NOT NULL,
    made_by UUID NOT NULL,
    expires_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);

CREATE TABLE sign_in_codes (
    school_id UUID NOT NULL,
    person_id UUID PRIMARY KEY,
    code_hash BYTEA NOT NULL CHECK (length(code_hash) = 32),
    made_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    UNIQUE (school_id, code_hash)
);

CREATE TABLE account_links (
    token_sha256 BYTEA PRIMARY KEY CHECK (length(token_sha256) = 32),
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    purpose TEXT COLLATE "C" NOT NULL CHECK (purpose IN ('invitation', 'reset')),
    expires_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);
CREATE INDEX account_links_by_person ON account_links (person_id);
CREATE INDEX account_links_by_expiry ON account_links (expires_at);

CREATE TABLE rosters (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    made_by UUID NOT NULL,
    file_name TEXT COLLATE "C" NOT NULL,
    body BYTEA NOT NULL,
    wanted TEXT COLLATE "C" NOT NULL, -- JSON
    made_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);
CREATE INDEX rosters_by_time ON rosters (made_at);
CREATE INDEX rosters_by_school ON rosters (school_id);

CREATE TABLE assignments (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    exercise_id TEXT COLLATE "C", -- an exercise, or
    curriculum_id TEXT COLLATE "C", -- a course
    cohort_id UUID, -- of a cohort, or
    person_id UUID, -- of one trainee
    supervised BOOLEAN NOT NULL,
    attempt_limit BIGINT CHECK (attempt_limit > 0), -- of an exercise
    due_local TEXT COLLATE "C", -- 2026-11-30T18:00:00
    time_zone TEXT COLLATE "C" NOT NULL,
    due_at BIGINT,
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    withdrawn_at BIGINT,
    since_only BOOLEAN NOT NULL DEFAULT FALSE,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, exercise_id) REFERENCES exercises (school_id, exercise_id),
    FOREIGN KEY (school_id, curriculum_id) REFERENCES curricula (school_id, curriculum_id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id),
    CHECK ((exercise_id IS NULL) <> (curriculum_id IS NULL)),
    CHECK ((cohort_id IS NULL) <> (person_id IS NULL)),
    CHECK ((due_local IS NULL) = (due_at IS NULL))
);
CREATE INDEX assignments_by_cohort ON assignments (cohort_id, due_at) WHERE cohort_id IS NOT NULL;
CREATE INDEX assignments_by_person ON assignments (person_id, due_at) WHERE person_id IS NOT NULL;
CREATE INDEX assignments_by_due ON assignments (due_at) WHERE due_at IS NOT NULL AND withdrawn_at IS NULL;
CREATE INDEX assignments_by_school ON assignments (school_id, made_at);

CREATE TABLE assignment_extensions (
    school_id UUID NOT NULL,
    assignment_id UUID NOT NULL,
    person_id UUID NOT NULL,
    days BIGINT NOT NULL CHECK (days BETWEEN 1 AND 366),
    due_at BIGINT NOT NULL,
    PRIMARY KEY (assignment_id, person_id),
    FOREIGN KEY (school_id, assignment_id) REFERENCES assignments (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);
CREATE INDEX assignment_extensions_by_due ON assignment_extensions (due_at);
CREATE INDEX assignment_extensions_by_person ON assignment_extensions (person_id, assignment_id);

CREATE TABLE score_overrides (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    score DOUBLE PRECISION CHECK (score BETWEEN 0 AND 100), -- 0–100
    passed BOOLEAN,
    reason TEXT COLLATE "C" NOT NULL CHECK (length(trim(reason)) > 0),
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    rowid BIGINT GENERATED ALWAYS AS IDENTITY, -- in the order of arrival
    CHECK ((score IS NULL) = (passed IS NULL)),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);
CREATE INDEX score_overrides_by_session ON score_overrides (school_id, session_id, made_at, id);
CREATE INDEX score_overrides_by_maker ON score_overrides (school_id, made_by, made_at);

CREATE TABLE grades (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    score_id UUID NOT NULL REFERENCES scores (id), -- the newest computed score
    override_id UUID REFERENCES score_overrides (id), -- the override that counts in its place
    score DOUBLE PRECISION NOT NULL, -- 0–100
    passed BOOLEAN NOT NULL,
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);

CREATE TABLE reviews (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    reviewed_by UUID NOT NULL,
    reviewed_at BIGINT NOT NULL,
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, reviewed_by) REFERENCES people (school_id, id)
);
CREATE INDEX reviews_by_reviewer ON reviews (school_id, reviewed_by);

CREATE TABLE comments (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    author_id UUID NOT NULL,
    answers UUID, -- the comment that this one answers; else this one has a kind and a moment
    kind TEXT COLLATE "C" CHECK (kind IN ('praise', 'error', 'question', 'teaching')),
    from_s DOUBLE PRECISION CHECK (from_s >= 0), -- since the start of the attempt
    to_s DOUBLE PRECISION CHECK (to_s >= from_s), -- absent: a moment
    body TEXT COLLATE "C" NOT NULL CHECK (length(trim(body)) > 0),
    made_at BIGINT NOT NULL,
    withdrawn_at BIGINT,
    UNIQUE (school_id, session_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, author_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id, answers) REFERENCES comments (school_id, session_id, id),
    CHECK ((answers IS NULL) = (kind IS NOT NULL)),
    CHECK ((answers IS NULL) = (from_s IS NOT NULL))
);
CREATE INDEX comments_by_session ON comments (school_id, session_id, made_at, id);
CREATE INDEX comments_by_author ON comments (school_id, author_id, made_at);

CREATE TABLE recording_links (
    token_sha256 BYTEA PRIMARY KEY CHECK (length(token_sha256) = 32),
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    made_by UUID NOT NULL,
    expires_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);
CREATE INDEX recording_links_by_expiry ON recording_links (expires_at);
CREATE INDEX recording_links_by_maker ON recording_links (made_by);

CREATE TABLE instrument_revisions (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    instrument_id TEXT COLLATE "C" NOT NULL,
    title TEXT COLLATE "C" NOT NULL,
    sha256 TEXT COLLATE "C" NOT NULL,
    bytes BYTEA NOT NULL,
    published_at BIGINT NOT NULL,
    UNIQUE (school_id, id),
    UNIQUE (school_id, sha256)
);
CREATE INDEX instrument_revisions_by_instrument ON instrument_revisions (school_id, instrument_id, published_at);

CREATE TABLE instruments (
    school_id UUID NOT NULL REFERENCES schools (id),
    instrument_id TEXT COLLATE "C" NOT NULL,
    revision_id UUID NOT NULL,
    PRIMARY KEY (school_id, instrument_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id)
);

CREATE TABLE studies (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    title TEXT COLLATE "C" NOT NULL CHECK (length(trim(title)) > 0),
    owner_id UUID NOT NULL,
    attempts BIGINT NOT NULL CHECK (attempts BETWEEN 1 AND 50), -- asked of each participant at each exercise
    groups TEXT COLLATE "C" NOT NULL, -- JSON: names, from the least experienced to the experts
    questions TEXT COLLATE "C" NOT NULL, -- JSON: what is asked of each participant
    consent TEXT COLLATE "C" NOT NULL CHECK (length(trim(consent)) > 0), -- what they agree to
    controller TEXT COLLATE "C" NOT NULL CHECK (length(trim(controller)) > 0), -- who answers for the data
    contact TEXT COLLATE "C" NOT NULL CHECK (length(trim(contact)) > 0),
    kept_months BIGINT NOT NULL CHECK (kept_months BETWEEN 1 AND 360), -- after its end
    generated BOOLEAN NOT NULL DEFAULT FALSE, -- the participants are a program's
    created_at BIGINT NOT NULL,
    closed_at BIGINT,
    told_at BIGINT,
    told_observed_s BIGINT,
    erased_at BIGINT,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, owner_id) REFERENCES people (school_id, id)
);
CREATE INDEX studies_by_time ON studies (school_id, created_at);
CREATE INDEX studies_by_owner ON studies (school_id, owner_id);
CREATE INDEX studies_to_erase ON studies (school_id, closed_at) WHERE closed_at IS NOT NULL AND erased_at IS NULL;

CREATE TABLE surveys (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    revision_id UUID NOT NULL,
    title TEXT COLLATE "C" NOT NULL,
    owner_id UUID, -- absent: a course asks for it, and the administrators own it
    identity TEXT COLLATE "C" NOT NULL CHECK (identity IN ('anonymous', 'pseudonymous', 'named')),
    after_attempts BOOLEAN NOT NULL, -- asked after each attempt, not once
    generated BOOLEAN NOT NULL, -- the answers were made by a program
    opens_at BIGINT NOT NULL,
    closes_at BIGINT,
    created_at BIGINT NOT NULL,
    study_id UUID REFERENCES studies (id),
    at_end BOOLEAN NOT NULL DEFAULT FALSE,
    fresh_hours BIGINT CHECK (fresh_hours > 0),
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id),
    FOREIGN KEY (school_id, owner_id) REFERENCES people (school_id, id)
);
CREATE INDEX surveys_by_time ON surveys (school_id, created_at);
CREATE INDEX surveys_after_attempts ON surveys (school_id, created_at) WHERE after_attempts;
CREATE INDEX surveys_of_study ON surveys (school_id, study_id) WHERE study_id IS NOT NULL;

CREATE TABLE survey_cohorts (
    school_id UUID NOT NULL,
    survey_id UUID NOT NULL,
    cohort_id UUID NOT NULL,
    PRIMARY KEY (survey_id, cohort_id),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id)
);
CREATE INDEX survey_cohorts_by_cohort ON survey_cohorts (cohort_id, survey_id);

CREATE TABLE survey_exercises (
    school_id UUID NOT NULL,
    survey_id UUID NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (survey_id, exercise_id),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id)
);

CREATE TABLE survey_responses (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    survey_id UUID NOT NULL,
    token_sha256 BYTEA NOT NULL UNIQUE CHECK (length(token_sha256) = 32),
    state TEXT COLLATE "C" NOT NULL CHECK (state IN ('invited', 'begun', 'submitted', 'withdrawn')),
    role TEXT COLLATE "C" NOT NULL, -- 'professional' for a link, or the person's
    label TEXT COLLATE "C", -- whom a link was made for
    person_id UUID,
    session_id UUID,
    exercise_id TEXT COLLATE "C", -- of the attempt, as the next two
    device TEXT COLLATE "C",
    simulator_version TEXT COLLATE "C",
    language TEXT COLLATE "C" NOT NULL,
    answers TEXT COLLATE "C" NOT NULL, -- JSON: an array in the order of the instrument's items
    consented_at BIGINT,
    expires_at BIGINT, -- of a link
    submitted_at BIGINT,
    UNIQUE (school_id, id),
    CHECK ((state = 'submitted') = (submitted_at IS NOT NULL)),
    CHECK (state IN ('invited', 'withdrawn') OR consented_at IS NOT NULL),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);
CREATE INDEX survey_responses_by_survey ON survey_responses (school_id, survey_id, state);
CREATE UNIQUE INDEX survey_responses_of_person ON survey_responses (survey_id, person_id, session_id) NULLS NOT DISTINCT
WHERE person_id IS NOT NULL;
CREATE INDEX survey_responses_by_person ON survey_responses (school_id, person_id) WHERE person_id IS NOT NULL;

CREATE TABLE survey_participations (
    school_id UUID NOT NULL,
    survey_id UUID NOT NULL,
    person_id UUID NOT NULL,
    session_id UUID,
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);
CREATE UNIQUE INDEX survey_participations_once ON survey_participations (survey_id, person_id, session_id) NULLS NOT DISTINCT;
CREATE INDEX survey_participations_by_person ON survey_participations (school_id, person_id);

CREATE TABLE survey_tags (
    school_id UUID NOT NULL,
    survey_id UUID NOT NULL,
    response_id UUID NOT NULL,
    item_id TEXT COLLATE "C" NOT NULL,
    tag TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (response_id, item_id, tag),
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, response_id) REFERENCES survey_responses (school_id, id)
);
CREATE INDEX survey_tags_by_survey ON survey_tags (school_id, survey_id);

CREATE TABLE practice (
    school_id UUID NOT NULL,
    trainee_id UUID NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    attempts BIGINT NOT NULL, -- scored ones
    passes BIGINT NOT NULL,
    points DOUBLE PRECISION NOT NULL, -- sum of the scores
    history TEXT COLLATE "C" NOT NULL, -- JSON: [[session, started µs, score, passed, revision], …]
    PRIMARY KEY (school_id, trainee_id, exercise_id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id)
);

CREATE TABLE tallies (
    school_id UUID NOT NULL REFERENCES schools (id),
    cohort_id UUID NOT NULL,
    month BIGINT NOT NULL, -- 12 × year + month − 1, UTC
    attempts BIGINT NOT NULL,
    passes BIGINT NOT NULL,
    points DOUBLE PRECISION NOT NULL,
    PRIMARY KEY (school_id, cohort_id, month)
);

CREATE TABLE regradings (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    exercise_id TEXT COLLATE "C" NOT NULL,
    revision_id UUID NOT NULL, -- whose rubric judges
    state TEXT COLLATE "C" NOT NULL CHECK (state IN ('looking', 'shown', 'grading', 'done')),
    reason TEXT COLLATE "C" CHECK (length(trim(reason)) > 0),
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    confirmed_at BIGINT,
    ended_at BIGINT,
    counts TEXT COLLATE "C" NOT NULL DEFAULT '[]',
    shown_sha256 TEXT COLLATE "C",
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, exercise_id) REFERENCES exercises (school_id, exercise_id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id),
    CHECK ((state IN ('grading', 'done')) = (reason IS NOT NULL)),
    CHECK ((reason IS NULL) = (confirmed_at IS NULL))
);
CREATE INDEX regradings_by_exercise ON regradings (school_id, exercise_id, made_at);
CREATE INDEX regradings_under_way ON regradings (made_at) WHERE state IN ('looking', 'grading');

CREATE TABLE regrading_lines (
    school_id UUID NOT NULL,
    regrading_id UUID NOT NULL,
    session_id UUID NOT NULL,
    score_id UUID NOT NULL REFERENCES scores (id), -- the newest computed score
    override_id UUID REFERENCES score_overrides (id), -- what counts in its place
    before DOUBLE PRECISION NOT NULL, -- the computed score, 0–100
    passed_before BOOLEAN NOT NULL,
    after DOUBLE PRECISION, -- 0–100
    passed_after BOOLEAN,
    outcome TEXT COLLATE "C"
        CHECK (outcome IN ('passes', 'fails', 'changed', 'overridden', 'equal', 'same', 'unreadable', 'overtaken')), -- absent: not looked at yet
    why TEXT COLLATE "C", -- it cannot be read
    assessment TEXT COLLATE "C", -- JSON, until it has become a score
    new_score_id UUID REFERENCES scores (id),
    PRIMARY KEY (school_id, regrading_id, session_id),
    FOREIGN KEY (school_id, regrading_id) REFERENCES regradings (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);
CREATE INDEX regrading_lines_by_outcome ON regrading_lines (regrading_id, outcome, session_id);
CREATE INDEX regrading_lines_to_grade ON regrading_lines (regrading_id, session_id) WHERE assessment IS NOT NULL;
CREATE INDEX regrading_lines_by_session ON regrading_lines (school_id, session_id) WHERE new_score_id IS NOT NULL;

CREATE TABLE segment_tasks (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    title TEXT COLLATE "C" NOT NULL CHECK (length(trim(title)) > 0),
    cohort_id UUID NOT NULL,
    due_local TEXT COLLATE "C", -- 2026-11-30T18:00:00
    time_zone TEXT COLLATE "C" NOT NULL,
    due_at BIGINT,
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    withdrawn_at BIGINT,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id),
    CHECK ((due_local IS NULL) = (due_at IS NULL))
);
CREATE INDEX segment_tasks_by_school ON segment_tasks (school_id, made_at);
CREATE INDEX segment_tasks_by_cohort ON segment_tasks (cohort_id, made_at);
CREATE INDEX segment_tasks_by_due ON segment_tasks (due_at) WHERE due_at IS NOT NULL AND withdrawn_at IS NULL;

CREATE TABLE segment_extensions (
    school_id UUID NOT NULL,
    task_id UUID NOT NULL,
    person_id UUID NOT NULL,
    days BIGINT NOT NULL CHECK (days BETWEEN 1 AND 366),
    due_at BIGINT NOT NULL,
    PRIMARY KEY (task_id, person_id),
    FOREIGN KEY (school_id, task_id) REFERENCES segment_tasks (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);
CREATE INDEX segment_extensions_by_due ON segment_extensions (due_at);
CREATE INDEX segment_extensions_by_person ON segment_extensions (person_id, task_id);

CREATE TABLE rating_rounds (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    revision_id UUID NOT NULL,
    title TEXT COLLATE "C" NOT NULL CHECK (length(trim(title)) > 0),
    generated BOOLEAN NOT NULL, -- the ratings were made by a program
    made_by UUID NOT NULL,
    made_at BIGINT NOT NULL,
    withdrawn_at BIGINT,
    UNIQUE (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES instrument_revisions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);
CREATE INDEX rating_rounds_by_school ON rating_rounds (school_id, made_at);
CREATE INDEX rating_rounds_by_maker ON rating_rounds (school_id, made_by, made_at);

CREATE TABLE ratings (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    round_id UUID NOT NULL,
    session_id UUID NOT NULL,
    rater_id UUID NOT NULL,
    answers TEXT COLLATE "C" NOT NULL, -- JSON: an array in the order of the instrument's items
    finished_at BIGINT,
    may_know BOOLEAN NOT NULL DEFAULT FALSE,
    UNIQUE (round_id, session_id, rater_id),
    FOREIGN KEY (school_id, round_id) REFERENCES rating_rounds (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, rater_id) REFERENCES people (school_id, id)
);
CREATE INDEX ratings_by_rater ON ratings (school_id, rater_id, round_id);
CREATE INDEX ratings_by_session ON ratings (school_id, session_id);

CREATE TABLE segment_traces (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    task_id UUID NOT NULL,
    session_id UUID NOT NULL,
    position BIGINT NOT NULL, -- from 1
    UNIQUE (school_id, id),
    UNIQUE (task_id, session_id),
    FOREIGN KEY (school_id, task_id) REFERENCES segment_tasks (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id)
);

CREATE TABLE segment_marks (
    school_id UUID NOT NULL,
    trace_id UUID NOT NULL,
    person_id UUID NOT NULL,
    marks TEXT COLLATE "C" NOT NULL, -- JSON: moments since the start of the attempt, in s
    sent_at BIGINT, -- from then on they stay, for the truth has been shown
    PRIMARY KEY (trace_id, person_id),
    FOREIGN KEY (school_id, trace_id) REFERENCES segment_traces (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);
CREATE INDEX segment_marks_by_person ON segment_marks (school_id, person_id);

CREATE TABLE expert_declarations (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    wording TEXT COLLATE "C" NOT NULL CHECK (length(trim(wording)) > 0), -- what was agreed to
    how TEXT COLLATE "C" NOT NULL CHECK (length(trim(how)) > 0), -- how it was given
    given_at BIGINT NOT NULL,
    recorded_by UUID NOT NULL, -- themselves, or the administrator to whom they gave it
    withdrawn_at BIGINT,
    withdrawn_by UUID,
    CHECK ((withdrawn_at IS NULL) = (withdrawn_by IS NULL)),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, recorded_by) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, withdrawn_by) REFERENCES people (school_id, id)
);
CREATE UNIQUE INDEX expert_declarations_that_stand ON expert_declarations (school_id, person_id) WHERE withdrawn_at IS NULL;
CREATE INDEX expert_declarations_by_person ON expert_declarations (school_id, person_id, given_at);

CREATE TABLE supervisions (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    trainee_id UUID NOT NULL, -- of the attempt
    confirmed_by UUID NOT NULL,
    confirmed_at BIGINT NOT NULL,
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, trainee_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, confirmed_by) REFERENCES people (school_id, id)
);
CREATE INDEX supervisions_by_trainee ON supervisions (school_id, trainee_id);
CREATE INDEX supervisions_by_supervisor ON supervisions (school_id, confirmed_by);

CREATE TABLE survey_letters (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    survey_id UUID NOT NULL,
    name TEXT COLLATE "C" NOT NULL,
    email TEXT COLLATE "C" NOT NULL,
    response_id UUID, -- the link it holds; absent once it is out: then nothing leads from an address to an answer
    tries BIGINT NOT NULL DEFAULT 0,
    next_run_at BIGINT, -- absent: sent, given up, or on its way when the service ended
    sent_at BIGINT,
    error TEXT COLLATE "C",
    UNIQUE (survey_id, email), -- nobody is written to twice
    FOREIGN KEY (school_id, survey_id) REFERENCES surveys (school_id, id),
    FOREIGN KEY (school_id, response_id) REFERENCES survey_responses (school_id, id)
);
CREATE INDEX survey_letters_by_time ON survey_letters (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX survey_letters_by_address ON survey_letters (school_id, email);
CREATE INDEX survey_letters_by_survey ON survey_letters (school_id, survey_id, email);
CREATE INDEX survey_letters_by_response ON survey_letters (school_id, response_id);

CREATE TABLE cohort_requests (
    school_id UUID NOT NULL,
    cohort_id UUID NOT NULL,
    person_id UUID NOT NULL,
    asked_by UUID NOT NULL,
    asked_at BIGINT NOT NULL,
    PRIMARY KEY (cohort_id, person_id),
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, asked_by) REFERENCES people (school_id, id)
);
CREATE INDEX cohort_requests_by_person ON cohort_requests (person_id);
CREATE INDEX cohort_requests_by_school ON cohort_requests (school_id, asked_at);

CREATE TABLE cohort_acts (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    cohort_id UUID NOT NULL,
    person_id UUID NOT NULL,
    act TEXT COLLATE "C" NOT NULL CHECK (act IN ('asked', 'declined', 'joined', 'left')),
    done_by UUID, -- NULL: on the command line
    done_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, cohort_id) REFERENCES cohorts (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, done_by) REFERENCES people (school_id, id)
);
CREATE INDEX cohort_acts_by_person ON cohort_acts (school_id, person_id, done_at);

CREATE TABLE heartbeat (
    id BIGINT PRIMARY KEY CHECK (id = 1),
    beaten_at BIGINT NOT NULL -- µs since 1970, UTC
);

CREATE TABLE asked_links (
    email TEXT COLLATE "C" PRIMARY KEY CHECK (length(email) <= 254),
    asked_at BIGINT NOT NULL -- µs since 1970, UTC
);
CREATE INDEX asked_links_by_time ON asked_links (asked_at, email);

CREATE TABLE second_factors (
    person_id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    sealed_secret BYTEA NOT NULL, -- nonce and ciphertext: a copy of this file makes no code
    made_at BIGINT NOT NULL,
    confirmed_at BIGINT, -- absent: offered, and not asked for yet
    last_step BIGINT NOT NULL DEFAULT 0, -- time step of the last code that was taken, in 30 s since 1970 UTC
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE TABLE recovery_codes (
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    code_hash BYTEA NOT NULL CHECK (length(code_hash) = 32),
    PRIMARY KEY (person_id, code_hash),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);

CREATE TABLE service_time (
    id BIGINT PRIMARY KEY CHECK (id = 1),
    observed_s BIGINT NOT NULL,
    looked_s BIGINT
);

CREATE TABLE retention_warnings (
    id UUID PRIMARY KEY, -- also of the letter
    school_id UUID NOT NULL,
    person_id UUID NOT NULL UNIQUE,
    active_at BIGINT NOT NULL, -- when they had last done anything
    warned_at BIGINT NOT NULL,
    tries BIGINT NOT NULL DEFAULT 0,
    next_run_at BIGINT, -- of the letter; absent: it is out, or given up
    told_at BIGINT, -- when it was
    told_observed_s BIGINT, -- the same by service_time
    error TEXT COLLATE "C",
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((told_at IS NULL) = (told_observed_s IS NULL))
);
CREATE INDEX retention_warnings_by_time ON retention_warnings (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX retention_warnings_by_school ON retention_warnings (school_id);

CREATE TABLE regrade_reasons (
    score_id UUID PRIMARY KEY REFERENCES scores (id),
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    reason TEXT COLLATE "C" NOT NULL CHECK (length(trim(reason)) > 0),
    made_by UUID, -- NULL: on the command line
    made_at BIGINT NOT NULL,
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, made_by) REFERENCES people (school_id, id)
);
CREATE INDEX regrade_reasons_by_session ON regrade_reasons (school_id, session_id);
CREATE INDEX regrade_reasons_by_maker ON regrade_reasons (school_id, made_by);

CREATE TABLE readings (
    id UUID NOT NULL UNIQUE,
    school_id UUID NOT NULL REFERENCES schools (id),
    sha256 TEXT COLLATE "C" NOT NULL,
    begun BIGINT NOT NULL DEFAULT 0 CHECK (begun >= 0), -- readers at this moment
    deaths BIGINT NOT NULL DEFAULT 0,
    noted_at BIGINT NOT NULL,
    PRIMARY KEY (school_id, sha256)
);
CREATE INDEX readings_by_time ON readings (noted_at);

CREATE TABLE school_origins (
    school_id UUID NOT NULL REFERENCES schools (id),
    origin TEXT COLLATE "C" NOT NULL CHECK (origin ~ '^https?://.'),
    PRIMARY KEY (school_id, origin)
);
CREATE INDEX school_origins_by_origin ON school_origins (origin);

CREATE TABLE unhashed_motions (
    school_id UUID NOT NULL,
    session_id UUID NOT NULL,
    rowid BIGINT GENERATED ALWAYS AS IDENTITY, -- in the order of arrival
    PRIMARY KEY (school_id, session_id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id) ON DELETE CASCADE
);

CREATE TABLE passkeys (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    name TEXT COLLATE "C" NOT NULL,
    credential_id BYTEA NOT NULL UNIQUE, -- the authenticator's own name of it: nobody else's, whatever their school
    public_key TEXT COLLATE "C" NOT NULL, -- in JSON: the key, its counter, and what the authenticator said of itself
    sign_count BIGINT NOT NULL, -- signatures it has counted; 0 where it counts none
    made_at BIGINT NOT NULL,
    last_used_at BIGINT, -- absent: not since it was made
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id)
);
CREATE INDEX passkeys_by_person ON passkeys (school_id, person_id);

CREATE TABLE study_exercises (
    school_id UUID NOT NULL,
    study_id UUID NOT NULL,
    position BIGINT NOT NULL,
    revision_id UUID NOT NULL,
    PRIMARY KEY (study_id, position),
    UNIQUE (study_id, revision_id),
    FOREIGN KEY (school_id, study_id) REFERENCES studies (school_id, id),
    FOREIGN KEY (school_id, revision_id) REFERENCES exercise_revisions (school_id, id)
);

CREATE TABLE study_participants (
    school_id UUID NOT NULL,
    study_id UUID NOT NULL,
    person_id UUID NOT NULL,
    group_place BIGINT NOT NULL, -- in the study's groups
    facts TEXT COLLATE "C" NOT NULL, -- JSON: answers to the study's questions, in their order
    added_at BIGINT NOT NULL,
    added_by UUID NOT NULL,
    consented_at BIGINT NOT NULL,
    withdrawn_at BIGINT,
    PRIMARY KEY (study_id, person_id),
    FOREIGN KEY (school_id, study_id) REFERENCES studies (school_id, id),
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, added_by) REFERENCES people (school_id, id)
);
CREATE INDEX study_participants_by_person ON study_participants (school_id, person_id);
CREATE INDEX study_participants_by_adder ON study_participants (school_id, added_by);
CREATE INDEX study_participants_by_study ON study_participants (school_id, study_id, group_place, added_at);

CREATE TABLE notices (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL, -- whom it is for
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('comment', 'question', 'answer', 'override', 'rating', 'assignment')),
    by_id UUID NOT NULL, -- who did it
    session_id UUID, -- the attempt that it is about; absent for an assignment and for whoever asked for a round
    comment_id UUID,
    assignment_id UUID,
    round_id UUID,
    made_at BIGINT NOT NULL,
    read_at BIGINT, -- absent: it is new
    mailed_at BIGINT, -- when a letter that names it was queued
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, by_id) REFERENCES people (school_id, id),
    FOREIGN KEY (school_id, session_id) REFERENCES sessions (school_id, id),
    FOREIGN KEY (school_id, session_id, comment_id) REFERENCES comments (school_id, session_id, id)
);
CREATE INDEX notices_by_person ON notices (school_id, person_id, made_at);
CREATE INDEX notices_unread ON notices (school_id, person_id, made_at) WHERE read_at IS NULL;
CREATE INDEX notices_unmailed ON notices (made_at) WHERE read_at IS NULL AND mailed_at IS NULL;
CREATE INDEX notices_by_comment ON notices (comment_id) WHERE comment_id IS NOT NULL;
CREATE INDEX notices_by_assignment ON notices (assignment_id) WHERE assignment_id IS NOT NULL;
CREATE INDEX notices_by_round ON notices (round_id) WHERE round_id IS NOT NULL;
CREATE INDEX notices_by_author ON notices (school_id, by_id);
CREATE INDEX notices_by_session ON notices (school_id, session_id) WHERE session_id IS NOT NULL;

CREATE TABLE mails (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL,
    person_id UUID NOT NULL,
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('invitation', 'reset', 'reminder', 'second_factor_off', 'news')),
    assignment_id UUID, -- of a reminder
    tries BIGINT NOT NULL DEFAULT 0,
    next_run_at BIGINT, -- absent: sent, or given up
    sent_at BIGINT,
    error TEXT COLLATE "C",
    FOREIGN KEY (school_id, person_id) REFERENCES people (school_id, id),
    CHECK ((kind = 'reminder') = (assignment_id IS NOT NULL))
);
CREATE INDEX mails_by_time ON mails (next_run_at) WHERE next_run_at IS NOT NULL;
CREATE INDEX mails_by_person ON mails (school_id, person_id);
CREATE UNIQUE INDEX reminders_once ON mails (assignment_id, person_id) WHERE assignment_id IS NOT NULL;

CREATE TABLE roster_mappings (
    school_id UUID NOT NULL REFERENCES schools (id),
    headings_sha256 BYTEA NOT NULL CHECK (length(headings_sha256) = 32),
    mapping TEXT COLLATE "C" NOT NULL, -- JSON
    changed_at BIGINT NOT NULL,
    PRIMARY KEY (school_id, headings_sha256)
);

CREATE TABLE backups (
    id UUID PRIMARY KEY,
    made_at BIGINT NOT NULL,
    file_name TEXT COLLATE "C" NOT NULL,
    bytes BIGINT CHECK (bytes > 0),
    recordings BIGINT CHECK (recordings >= 0),
    keys_sealed BOOLEAN NOT NULL,
    error TEXT COLLATE "C", -- Why it was not made; what was made was read back and is whole.
    CHECK ((error IS NULL) = (bytes IS NOT NULL)),
    CHECK ((error IS NULL) = (recordings IS NOT NULL))
);
CREATE INDEX backups_by_time ON backups (made_at, id);

CREATE TABLE drafts (
    id UUID PRIMARY KEY,
    school_id UUID NOT NULL REFERENCES schools (id),
    kind TEXT COLLATE "C" NOT NULL CHECK (kind IN ('exercise', 'course', 'instrument')),
    document_id TEXT COLLATE "C" NOT NULL, -- of what it will be a revision
    based_on UUID, -- the revision of an exercise that its meshes come from
    document TEXT COLLATE "C" NOT NULL, -- TOML
    scene TEXT COLLATE "C" NOT NULL, -- TOML, of an exercise; empty for any other
    version BIGINT NOT NULL, -- grows with each save: a save names the one it has seen
    saved_by UUID NOT NULL,
    saved_at BIGINT NOT NULL,
    UNIQUE (school_id, kind, document_id),
    FOREIGN KEY (school_id, based_on) REFERENCES exercise_revisions (school_id, id),
    FOREIGN KEY (school_id, saved_by) REFERENCES people (school_id, id)
);

CREATE TABLE exercise_pictures (
    revision_id UUID NOT NULL REFERENCES exercise_revisions (id),
    position BIGINT NOT NULL, -- its row in the exercise, from 0
    name TEXT COLLATE "C" NOT NULL, -- as the exercise names it
    sha256 TEXT COLLATE "C" NOT NULL,
    width BIGINT NOT NULL, -- pixels
    height BIGINT NOT NULL,
    bytes BYTEA NOT NULL,
    PRIMARY KEY (revision_id, position)
);

CREATE TABLE draft_pictures (
    draft_id UUID NOT NULL REFERENCES drafts (id) ON DELETE CASCADE,
    name TEXT COLLATE "C" NOT NULL,
    sha256 TEXT COLLATE "C" NOT NULL,
    width BIGINT NOT NULL,
    height BIGINT NOT NULL,
    bytes BYTEA NOT NULL,
    PRIMARY KEY (draft_id, name)
);

CREATE TABLE school_logos (
    school_id UUID PRIMARY KEY REFERENCES schools (id),
    media_type TEXT COLLATE "C" NOT NULL CHECK (media_type IN ('image/png', 'image/jpeg')),
    width BIGINT NOT NULL CHECK (width > 0),
    height BIGINT NOT NULL CHECK (height > 0),
    bytes BYTEA NOT NULL,
    version TEXT COLLATE "C" NOT NULL
        CHECK (length(version) = 32) -- The first half of its SHA-256, hexadecimal: its address changes with it.
);
