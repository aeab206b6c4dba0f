# cardan with its workbench, in a slim image; docs/index.md says how to run it.
FROM node:22-slim AS page
WORKDIR /build/web
COPY web/package.json web/package-lock.json ./
RUN npm ci --silent
COPY web ./
COPY src/cardan/web/messages.schema.json ../src/cardan/web/
RUN npm run --silent build

FROM python:3.13-slim AS wheel
WORKDIR /build
COPY pyproject.toml README.md LICENSE ./
COPY examples examples
COPY src src
COPY web/hatch_build.py web/
COPY --from=page /build/src/cardan/web/static src/cardan/web/static
RUN python -m pip wheel --no-cache-dir --no-deps --wheel-dir /wheels .

FROM python:3.13-slim
ARG EXTRAS=web,report,recordings
COPY constraints.txt /tmp/constraints.txt
# The wheel is read from its stage, so that no layer keeps a copy of it.
RUN --mount=from=wheel,source=/wheels,target=/wheels \
    python -m pip install --no-cache-dir --constraint /tmp/constraints.txt \
      "cardan[$EXTRAS] @ file://$(ls /wheels/*.whl)"
RUN useradd --create-home cardan
USER cardan
# Caches go where any user may write: --user names one that has no home here.
ENV HOME=/tmp
WORKDIR /work
# The workbench ends on what a keyboard sends.
STOPSIGNAL SIGINT
ENTRYPOINT ["cardan"]
CMD ["serve", "--no-browser", "--port", "8000"]
