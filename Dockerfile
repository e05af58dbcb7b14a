# The study in a container: `docker build -t bipedstudy .` computes it, `docker run bipedstudy claims` asks it.
# Not built yet by anybody who could say so here; what it runs is what .github/workflows/nightly.yml runs.
FROM python:3.11.9-slim-bookworm AS tools
RUN apt-get update -qq \
 && apt-get install -y -qq --no-install-recommends git libgl1 libx11-6 make \
 && rm -rf /var/lib/apt/lists/*

FROM tools AS study
WORKDIR /study
COPY . .
RUN make study
ENTRYPOINT ["/study/.venv/bin/bipedstudy"]
CMD ["--help"]
