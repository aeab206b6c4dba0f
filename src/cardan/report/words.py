"""The message catalogue: what reports say in English, in Portuguese of Brazil, in Italian.

Names of quantities are not here: they stand with their declaration in
`cardan.quantity.quantities`. A test looks for every text the program says.
"""

_VERDICTS: dict[str, tuple[str, str]] = {
    "pass": ("aprovado", "conforme"),
    "warn": ("alerta", "attenzione"),
    "fail": ("reprovado", "non conforme"),
    "verdict": ("veredicto", "esito"),
    "Verdict": ("Veredicto", "Esito"),
    "Verdicts": ("Veredictos", "Esiti"),
    "limit": ("limite", "limite"),
    "limits": ("limites", "limiti"),
    "Limits": ("Limites", "Limiti"),
    "limits: {profile}": ("limites: {profile}", "limiti: {profile}"),
    "checks": ("verificações", "verifiche"),
    "Checks": ("Verificações", "Verifiche"),
    "where it is worst": ("onde é pior", "dove è peggiore"),
    "value": ("valor", "valore"),
    "bound": ("limite", "limite"),
    "unit": ("unidade", "unità"),
    "margin": ("margem", "margine"),
    "source": ("fonte", "fonte"),
    "Source": ("Fonte", "Fonte"),
    "outside": ("fora de", "fuori da"),
    "normal": ("normal", "normale"),
    "maximum": ("máximo", "massimo"),
    "outside {low} … {high}": ("fora de {low} … {high}", "fuori da {low} … {high}"),
    "Every limit, where it is worst": ("Cada limite, onde é pior", "Ogni limite, dove è peggiore"),
    "Where the limits come from": ("De onde vêm os limites", "Da dove vengono i limiti"),
    "Not asked, for want of data: {names}.": (
        "Não verificado, por falta de dados: {names}.",
        "Non verificato, per mancanza di dati: {names}.",
    ),
    "Note: {note}.": ("Nota: {note}.", "Nota: {note}."),
    "a spring's stated rate of {stated} N/mm is {apart} from the {table} N/mm of its own table, "
    "which counts": (
        "a rigidez declarada de uma mola, {stated} N/mm, está a {apart} dos {table} N/mm da sua "
        "própria tabela, que é a que vale",
        "la rigidezza dichiarata di una molla, {stated} N/mm, dista {apart} dai {table} N/mm della "
        "sua stessa tabella, che fa fede",
    ),
    "A bracket is given: `cardan bracket` shows its stresses, gauges and frequencies.": (
        "Há um suporte: `cardan bracket` mostra suas tensões, extensômetros e frequências.",
        "È data una staffa: `cardan bracket` ne mostra tensioni, estensimetri e frequenze.",
    ),
    "{what} in {state}: {value} against {limit} {unit}": (
        "{what} em {state}: {value} contra {limit} {unit}",
        "{what} in {state}: {value} contro {limit} {unit}",
    ),
    "{count} states": ("{count} estados", "{count} stati"),
}

_CHANGES: dict[str, tuple[str, str]] = {
    "What to change": ("O que mudar", "Cosa cambiare"),
    "What would help (each alone; `cardan fix` looks for the best together)": (
        "O que ajudaria (cada um sozinho; `cardan fix` procura o melhor conjunto)",
        "Cosa aiuterebbe (ciascuno da solo; `cardan fix` cerca il meglio insieme)",
    ),
    "What would help, each move alone": (
        "O que ajudaria, cada mudança sozinha",
        "Cosa aiuterebbe, ogni modifica da sola",
    ),
    "Corrections over all states at once, best first": (
        "Correções para todos os estados juntos, a melhor primeiro",
        "Correzioni su tutti gli stati insieme, la migliore per prima",
    ),
    "Everything passes; nothing needs to change.": (
        "Tudo aprovado; nada precisa mudar.",
        "Tutto conforme; non serve cambiare nulla.",
    ),
    "nothing that can be moved": ("nada que se possa mover", "nulla che si possa spostare"),
    "{move} gives {value}": ("{move} dá {value}", "{move} dà {value}"),
    "bearing {part} up {amount} mm": (
        "mancal {part} para cima {amount} mm", "supporto {part} in alto di {amount} mm",
    ),
    "bearing {part} down {amount} mm": (
        "mancal {part} para baixo {amount} mm", "supporto {part} in basso di {amount} mm",
    ),
    "bearing {part} to the right {amount} mm": (
        "mancal {part} para a direita {amount} mm", "supporto {part} a destra di {amount} mm",
    ),
    "bearing {part} to the left {amount} mm": (
        "mancal {part} para a esquerda {amount} mm", "supporto {part} a sinistra di {amount} mm",
    ),
    "pinion nose up {amount} deg": (
        "nariz do pinhão para cima {amount} deg", "naso del pignone in alto di {amount} deg",
    ),
    "pinion nose down {amount} deg": (
        "nariz do pinhão para baixo {amount} deg", "naso del pignone in basso di {amount} deg",
    ),
    "rear yoke of shaft {part} turned {amount} deg": (
        "garfo traseiro do eixo {part} girado {amount} deg",
        "forcella posteriore dell'albero {part} ruotata di {amount} deg",
    ),
    "{low} to {high}": ("{low} até {high}", "da {low} a {high}"),
    "smallest margin {margin}, cost {cost}": (
        "menor margem {margin}, custo {cost}", "margine minimo {margin}, costo {cost}",
    ),
    "still {grade}: {check}": ("ainda {grade}: {check}", "ancora {grade}: {check}"),
    "Line {line}, smallest margin as installed {margin}.": (
        "Linha {line}, menor margem como instalada {margin}.",
        "Linea {line}, margine minimo come installata {margin}.",
    ),
    "Cost is the share of the given ranges in use; a turned yoke counts 0.5.": (
        "O custo é a parcela usada das faixas dadas; um garfo girado conta 0,5.",
        "Il costo è la quota usata dei campi dati; una forcella ruotata conta 0,5.",
    ),
    "Nothing that may be moved changes any limit: see `adjust` in the application file.": (
        "Nada que possa ser movido muda algum limite: veja `adjust` no arquivo da aplicação.",
        "Nulla di ciò che si può spostare cambia un limite: vedi `adjust` nel file "
        "dell'applicazione.",
    ),
}  # fmt: skip

_STORY: dict[str, tuple[str, str]] = {
    "Driveline approval report": (
        "Relatório de aprovação da linha de transmissão",
        "Rapporto di approvazione della trasmissione",
    ),
    "Contents": ("Conteúdo", "Indice"),
    "Inputs": ("Dados de entrada", "Dati di ingresso"),
    "Results by state": ("Resultados por estado", "Risultati per stato"),
    "Drawings": ("Desenhos", "Disegni"),
    "Plots": ("Gráficos", "Grafici"),
    "Equations and sources": ("Equações e fontes", "Equazioni e fonti"),
    "Approval": ("Aprovação", "Approvazione"),
    "Quantities of this report": ("Grandezas deste relatório", "Grandezze di questo rapporto"),
    "Revisions": ("Revisões", "Revisioni"),
    "Agreed between": ("Acordado entre", "Concordato tra"),
    "revision": ("revisão", "revisione"),
    "date": ("data", "data"),
    "Date": ("Data", "Data"),
    "File": ("Arquivo", "File"),
    "Made with": ("Feito com", "Prodotto con"),
    "Made with cardan {version}.": (
        "Feito com cardan {version}.",
        "Prodotto con cardan {version}.",
    ),
    "change": ("alteração", "modifica"),
    "made by": ("feito por", "redatto da"),
    "checked by": ("verificado por", "verificato da"),
    "first issue": ("primeira emissão", "prima emissione"),
    "vehicle maker": ("fabricante do veículo", "costruttore del veicolo"),
    "driveline maker": ("fabricante do cardan", "costruttore della trasmissione"),
    "company": ("empresa", "azienda"),
    "name": ("nome", "nome"),
    "signature": ("assinatura", "firma"),
    "Application file {file}": ("Arquivo da aplicação {file}", "File dell'applicazione {file}"),
    "input": ("dado", "dato"),
    "quantity": ("grandeza", "grandezza"),
    "symbol": ("símbolo", "simbolo"),
    "equation": ("equação", "equazione"),
    "limits of use": ("limites de uso", "limiti d'uso"),
    "Limits of use": ("Limites de uso", "Limiti d'uso"),
    "Variants side by side": ("Variantes lado a lado", "Varianti a confronto"),
    "variant": ("variante", "variante"),
    "What differs in the input": ("O que difere nos dados", "Cosa cambia nei dati"),
    "Inputs that differ": ("Dados que diferem", "Dati che cambiano"),
    "What it does to each limit, where it is worst": (
        "O que isso faz a cada limite, onde é pior",
        "Che effetto ha su ogni limite, dove è peggiore",
    ),
    "Value and margin": ("Valor e margem", "Valore e margine"),
    "nothing": ("nada", "nulla"),
    "* the verdict differs": ("* o veredicto difere", "* l'esito cambia"),
    "{file} is written.": ("{file} foi gravado.", "{file} è stato scritto."),
    "a workbook holds one application: give one file with --xlsx": (
        "uma planilha contém uma aplicação: dê um só arquivo com --xlsx",
        "una cartella di lavoro contiene un'applicazione: dare un solo file con --xlsx",
    ),
    "Demand": ("Solicitação", "Sollecitazione"),
    "Joints": ("Juntas", "Giunti"),
    "Excitation": ("Excitação", "Eccitazione"),
    "Centre bearings": ("Mancais centrais", "Supporti centrali"),
    "Gearbox, axle and spline": ("Caixa, eixo e luva", "Cambio, ponte e scanalato"),
    "Speed and strength": ("Rotação e resistência", "Velocità e resistenza"),
    "Room": ("Espaço", "Spazio"),
    "AE-7": ("AE-7", "AE-7"),
    "all joints in one plane": ("todas as juntas num plano", "tutti i giunti in un piano"),
    "ω² sin²": ("ω² sen²", "ω² sen²"),
    "3.3403e-6 N²θ²": ("3,3403e-6 N²θ²", "3,3403e-6 N²θ²"),
    "small angle": ("ângulo pequeno", "angolo piccolo"),
}

_PARTS: dict[str, tuple[str, str]] = {
    "line": ("linha", "linea"),
    "joint": ("junta", "giunto"),
    "shaft": ("eixo", "albero"),
    "bearing": ("mancal", "supporto"),
    "centre bearing": ("mancal central", "supporto centrale"),
    "pinion": ("pinhão", "pignone"),
    "{part} to {other}": ("{part} a {other}", "{part} da {other}"),
    "Line {line}": ("Linha {line}", "Linea {line}"),
    "Line {line}: {shafts} shaft, {joints} joints": (
        "Linha {line}: {shafts} eixo, {joints} juntas universais",
        "Linea {line}: {shafts} albero, {joints} giunti cardanici",
    ),
    "Line {line}: {shafts} shafts, {joints} joints": (
        "Linha {line}: {shafts} eixos, {joints} juntas universais",
        "Linea {line}: {shafts} alberi, {joints} giunti cardanici",
    ),
    "full rebound": ("extensão total", "estensione totale"),
    "rebound": ("extensão", "estensione"),
    "curb": ("chassi", "telaio"),
    "empty": ("vazio", "vuoto"),
    "gvw": ("PBT", "pieno carico"),
    "overload": ("sobrecarga", "sovraccarico"),
    "jounce": ("batente", "tampone"),
    "windup": ("torção do eixo", "rotazione ponte"),
    "windup brake": ("torção na frenagem", "rotazione in frenata"),
    "as given": ("como dado", "come dato"),
}

_INPUTS: dict[str, tuple[str, str]] = {
    "Application": ("Aplicação", "Applicazione"),
    "Vehicle": ("Veículo", "Veicolo"),
    "Engine and gearbox": ("Motor e câmbio", "Motore e cambio"),
    "Suspension": ("Suspensão", "Sospensione"),
    "States": ("Estados", "Stati"),
    "states": ("estados", "stati"),
    "Obstacles": ("Obstáculos", "Ostacoli"),
    "limit profile": ("perfil de limites", "profilo dei limiti"),
    "shaft torque": ("torque no eixo", "coppia all'albero"),
    "coast torque": ("torque em retenção", "coppia in rilascio"),
    "shaft speed": ("rotação do eixo", "velocità dell'albero"),
    "shock factor": ("fator de choque", "fattore d'urto"),
    "prime mover factor": ("fator do motor", "fattore del motore"),
    "loads include": ("cargas incluem", "i carichi comprendono"),
    "gravity": ("peso", "peso"),
    "unbalance": ("desbalanceamento", "squilibrio"),
    "duty point {number}": ("ponto de uso {number}", "punto d'impiego {number}"),
    "drive": ("tração", "trazione"),
    "wheelbase": ("entre-eixos", "passo"),
    "share of the rear load that is driven": (
        "parcela trativa da carga traseira", "quota motrice del carico posteriore",
    ),
    "grade": ("rampa", "pendenza"),
    "load {name}": ("carga {name}", "carico {name}"),
    "auxiliary axle {number}": ("eixo auxiliar {number}", "asse ausiliario {number}"),
    "tyre, static radius": ("pneu, raio estático", "pneumatico, raggio statico"),
    "tyre, friction": ("pneu, atrito", "pneumatico, aderenza"),
    "mass": ("massa", "massa"),
    "front axles": ("eixos dianteiros", "assi anteriori"),
    "rear axles": ("eixos traseiros", "assi posteriori"),
    "centre of gravity behind the front axle": (
        "centro de gravidade atrás do eixo dianteiro", "baricentro dietro l'asse anteriore",
    ),
    "height of the centre of gravity": (
        "altura do centro de gravidade", "altezza del baricentro",
    ),
    "engine speed": ("rotação do motor", "velocità del motore"),
    "engine torque": ("torque do motor", "coppia del motore"),
    "engine brake torque": ("torque do freio-motor", "coppia del freno motore"),
    "gear ratios": ("relações do câmbio", "rapporti del cambio"),
    "gearbox efficiency": ("rendimento do câmbio", "rendimento del cambio"),
    "converter torque ratio": ("relação do conversor", "rapporto del convertitore"),
    "transfer case, low range": ("caixa de transferência, reduzida", "ripartitore, ridotte"),
    "spring load": ("carga da mola", "carico della molla"),
    "spring deflection": ("deflexão da mola", "freccia della molla"),
    "springs per axle": ("molas por eixo", "molle per asse"),
    "unsprung mass": ("massa não suspensa", "massa non sospesa"),
    "equivalent link radius": ("raio do braço equivalente", "raggio del braccio equivalente"),
    "link angle": ("ângulo do braço", "angolo del braccio"),
    "pitch rate": ("taxa de rotação", "tasso di beccheggio"),
    "linkage table, travel": ("tabela de guia, curso", "tabella della guida, corsa"),
    "wind-up stiffness": ("rigidez à torção do eixo", "rigidezza alla rotazione del ponte"),
    "brake torque on the axle": ("torque de frenagem no eixo", "coppia frenante sull'asse"),
    "reference state": ("estado de referência", "stato di riferimento"),
    "deflection at full rebound": ("deflexão na extensão total", "freccia in estensione totale"),
    "deflection at jounce": ("deflexão no batente", "freccia al tampone"),
    "axle ratio": ("relação do eixo", "rapporto al ponte"),
    "axle efficiency": ("rendimento do eixo", "rendimento del ponte"),
    "share of the torque": ("parcela do torque", "quota della coppia"),
    "side slopes of the members": (
        "inclinações laterais dos membros", "inclinazioni laterali dei membri",
    ),
    "top slopes of the members": (
        "inclinações em planta dos membros", "inclinazioni in pianta dei membri",
    ),
    "joints": ("juntas", "giunti"),
    "length": ("comprimento", "lunghezza"),
    "tube": ("tubo", "tubo"),
    "yoke phase": ("fase dos garfos", "fase delle forcelle"),
    "centre bearing ahead of the rear joint": (
        "mancal central à frente da junta traseira",
        "supporto centrale davanti al giunto posteriore",
    ),
    "bearing stiffness, vertical and lateral": (
        "rigidez do mancal, vertical e lateral", "rigidezza del supporto, verticale e laterale",
    ),
    "spline plunge": ("luva, curso de entrada", "scanalato, corsa in entrata"),
    "spline draw": ("luva, curso de saída", "scanalato, corsa in uscita"),
    "yoke masses, front and rear": (
        "massas dos garfos, dianteiro e traseiro", "masse delle forcelle, anteriore e posteriore",
    ),
    "balance grade": ("grau de balanceamento", "grado di equilibratura"),
    "axle travel": ("curso do eixo", "corsa dell'asse"),
    "pinion pitch": ("rotação do pinhão", "beccheggio del pignone"),
    "torque": ("torque", "coppia"),
    "speed": ("rotação", "velocità"),
    "placed by the suspension": ("posicionado pela suspensão", "posizionato dalla sospensione"),
    "own geometry": ("geometria própria", "geometria propria"),
    "radius": ("raio", "raggio"),
    "share of the axle travel": ("parcela do curso do eixo", "quota della corsa dell'asse"),
}  # fmt: skip

_DRAWINGS: dict[str, tuple[str, str]] = {
    "Side view, from the left": ("Vista lateral, da esquerda", "Vista laterale, da sinistra"),
    "Top view": ("Vista superior", "Vista dall'alto"),
    "to scale": ("em escala", "in scala"),
    "to scale, exaggerated {times} times across": (
        "em escala, ampliada {times} vezes na transversal",
        "in scala, amplificata {times} volte in trasversale",
    ),
    "along the line; {times}:1 across": (
        "ao longo da linha; {times}:1 na transversal", "lungo la linea; {times}:1 in trasversale",
    ),
    "Bold: as installed. Light: the states, named at the pinion. At each joint its angle in this "
    "view, on each shaft its slope and length; angles are the real ones, not the exaggerated.": (
        "Forte: como instalado. Leve: os estados, nomeados no pinhão. Em cada junta o ângulo nesta "
        "vista, em cada eixo a inclinação e o comprimento; os ângulos são os reais, não os "
        "ampliados.",
        "Marcato: come installato. Leggero: gli stati, indicati al pignone. A ogni giunto l'angolo "
        "in questa vista, a ogni albero inclinazione e lunghezza; gli angoli sono quelli reali, "
        "non quelli amplificati.",
    ),
    "{room} mm in {state}": ("{room} mm em {state}", "{room} mm in {state}"),
    "Yoke phasing": ("Fase dos garfos", "Fasatura delle forcelle"),
    "aligned (0 deg)": ("alinhado (0 deg)", "allineato (0 deg)"),
    "crossed (90 deg)": ("defasado (90 deg)", "sfasato (90 deg)"),
    "turned {angle} deg": ("girado {angle} deg", "ruotato di {angle} deg"),
    "front yoke": ("garfo dianteiro", "forcella anteriore"),
    "rear yoke": ("garfo traseiro", "forcella posteriore"),
    "Pin axis: the axis of a yoke's two ears. Dial: front yoke (solid) and rear yoke (dashed) of "
    "the shaft seen from the gearbox, looking rearward; a positive phase turns the rear yoke "
    "clockwise.": (
        "Eixo do pino: o eixo das duas orelhas de um garfo. Mostrador: garfo dianteiro (cheio) e "
        "traseiro (tracejado) do eixo vistos do câmbio, olhando para trás; uma fase positiva gira "
        "o garfo traseiro no sentido horário.",
        "Asse del perno: l'asse delle due orecchie di una forcella. Quadrante: forcella anteriore "
        "(continua) e posteriore (tratteggiata) dell'albero viste dal cambio, guardando indietro; "
        "una fase positiva ruota la forcella posteriore in senso orario.",
    ),
    "Joint planes in {state}": ("Planos das juntas em {state}", "Piani dei giunti in {state}"),
    "bend to the right, top view angle [deg]": (
        "desvio à direita, ângulo em planta [deg]", "piega a destra, angolo in pianta [deg]",
    ),
    "bend upward, − side view angle [deg]": (
        "desvio para cima, − ângulo lateral [deg]", "piega in alto, − angolo laterale [deg]",
    ),
    "Seen from behind, looking forward: where each joint bends the line. Position φ is counted "
    "from the right, over down.": (
        "Visto de trás, olhando para a frente: para onde cada junta desvia a linha. A posição φ é "
        "contada da direita, passando por baixo.",
        "Visto da dietro, guardando avanti: dove ogni giunto piega la linea. La posizione φ si "
        "conta da destra, passando per il basso.",
    ),
    "How the joints add up in {state}": (
        "Como as juntas se somam em {state}", "Come si sommano i giunti in {state}",
    ),
    "along position 0 [deg²]": ("na posição 0 [deg²]", "in posizione 0 [deg²]"),
    "along position 45 deg [deg²]": ("na posição 45 deg [deg²]", "in posizione 45 deg [deg²]"),
    "Each joint adds an arrow as long as its squared angle, turned by twice its position and by "
    "the yoke phases before it (AE-7). Black: the sum, equivalent angle {angle} deg. Dashed "
    "circles: limits of torsional acceleration at this speed.": (
        "Cada junta soma uma seta do tamanho do seu ângulo ao quadrado, girada do dobro da sua "
        "posição e das fases dos garfos antes dela (AE-7). Preto: a soma, ângulo resultante "
        "{angle} deg. Círculos tracejados: limites de aceleração torcional nesta rotação.",
        "Ogni giunto aggiunge una freccia lunga quanto il suo angolo al quadrato, ruotata del "
        "doppio della sua posizione e delle fasi delle forcelle che precedono (AE-7). Nero: la "
        "somma, angolo equivalente {angle} deg. Cerchi tratteggiati: limiti di accelerazione "
        "torsionale a questa velocità.",
    ),
}  # fmt: skip

_PLOTS: dict[str, tuple[str, str]] = {
    "Speed round the turn, {state}": (
        "Rotação ao longo da volta, {state}", "Velocità lungo il giro, {state}",
    ),
    "Acceleration round the turn, {state}": (
        "Aceleração ao longo da volta, {state}", "Accelerazione lungo il giro, {state}",
    ),
    "acceleration": ("aceleração", "accelerazione"),
    "gearbox angle θ [deg]": ("ângulo do câmbio θ [deg]", "angolo del cambio θ [deg]"),
    "Gearbox turning uniformly at {speed} rpm. Peak to peak in {unit}: {values}.": (
        "Câmbio girando uniformemente a {speed} rpm. Pico a pico em {unit}: {values}.",
        "Cambio in rotazione uniforme a {speed} rpm. Picco-picco in {unit}: {values}.",
    ),
    "Peak to peak in {unit}: {values}": (
        "Pico a pico em {unit}: {values}", "Picco-picco in {unit}: {values}",
    ),
    "{quantity} by state": ("{quantity} por estado", "{quantity} per stato"),
    "{quantity} over the travel": (
        "{quantity} ao longo do curso", "{quantity} lungo la corsa",
    ),
    "over the travel, axle not wound up": (
        "ao longo do curso, eixo sem torção", "lungo la corsa, ponte non ruotato",
    ),
    "axle travel, up is positive [mm]": (
        "curso do eixo, para cima positivo [mm]", "corsa dell'asse, in alto positiva [mm]",
    ),
    "0-to-peak; the curve at the line's top speed, states at their own. Bands: where the "
    "limit warns and fails.": (
        "Zero a pico; a curva na rotação máxima da linha, os estados na sua. Faixas: onde o limite "
        "alerta e reprova.",
        "Zero-picco; la curva alla velocità massima della linea, gli stati alla propria. Fasce: "
        "dove il limite avverte e respinge.",
    ),
    "Force on {part} round the turn": (
        "Força no {part} ao longo da volta", "Forza sul {part} lungo il giro",
    ),
    "Force on {part} by order": ("Força no {part} por ordem", "Forza sul {part} per ordine"),
    "Peak in N: {values}": ("Pico em N: {values}", "Picco in N: {values}"),
    "lateral force, to the right [N]": (
        "força lateral, à direita [N]", "forza laterale, a destra [N]",
    ),
    "vertical force, up [N]": ("força vertical, para cima [N]", "forza verticale, in alto [N]"),
    "Mean (mark) and ellipse twice a turn, exactly, at each state's torque.": (
        "Média (marca) e elipse duas vezes por volta, exatas, no torque de cada estado.",
        "Media (segno) ed ellisse due volte per giro, esatte, alla coppia di ogni stato.",
    ),
    "mean": ("média", "media"),
    "order {order}": ("ordem {order}", "ordine {order}"),
    "force [N]": ("força [N]", "forza [N]"),
    "0-to-peak along the major axis of each order's ellipse; orders of the shaft's speed.": (
        "Zero a pico no eixo maior da elipse de cada ordem; ordens da rotação do eixo.",
        "Zero-picco lungo l'asse maggiore dell'ellisse di ogni ordine; ordini della velocità "
        "dell'albero.",
    ),
    "Torque by gear, engine against slip": (
        "Torque por marcha, motor contra escorregamento", "Coppia per marcia, motore e slittamento",
    ),
    "gear {gear}": ("marcha {gear}", "marcia {gear}"),
    "tyres slip, {states}": ("pneus escorregam, {states}", "slittamento, {states}"),
    "Largest torque in N·m by gear: {values}": (
        "Maior torque em N·m por marcha: {values}", "Coppia massima in N·m per marcia: {values}",
    ),
    "shaft speed [rpm]": ("rotação do eixo [rpm]", "velocità dell'albero [rpm]"),
    "shaft torque [N·m]": ("torque no eixo [N·m]", "coppia all'albero [N·m]"),
    "Full load. Loads are computed with the smaller of engine and slip torque.": (
        "Plena carga. As cargas são calculadas com o menor entre motor e escorregamento.",
        "Pieno carico. I carichi si calcolano con la minore tra coppia motore e slittamento.",
    ),
    "Critical speeds and the speed range": (
        "Rotações críticas e faixa de rotação", "Velocità critiche e campo di velocità",
    ),
    "line, as beams": ("linha, como vigas", "linea, come travi"),
    "line on its rubber": ("linha sobre a borracha", "linea sulla gomma"),
    "speed range": ("faixa de rotação", "campo di velocità"),
    "Upright bars: critical speeds, the lowest over the states. Shaded: near half critical, where "
    "the joints excite twice a turn, and too near critical, by the profile's limits.": (
        "Barras verticais: rotações críticas, a menor entre os estados. Sombreado: perto da meia "
        "crítica, onde as juntas excitam duas vezes por volta, e perto demais da crítica, pelos "
        "limites do perfil.",
        "Barre verticali: velocità critiche, la minima tra gli stati. Ombreggiato: vicino alla "
        "semicritica, dove i giunti eccitano due volte per giro, e troppo vicino alla critica, "
        "secondo i limiti del profilo.",
    ),
    "Spring curve": ("Curva da mola", "Curva della molla"),
    "table of the spring": ("tabela da mola", "tabella della molla"),
    "deflection [mm]": ("deflexão [mm]", "freccia [mm]"),
    "load of one spring [kN]": ("carga de uma mola [kN]", "carico di una molla [kN]"),
}  # fmt: skip

_WORKBOOK: dict[str, tuple[str, str]] = {
    "Driveline workbook: change what is coloured, and every result follows.": (
        "Planilha da linha: mude o que está colorido e todos os resultados acompanham.",
        "Foglio della trasmissione: si cambia ciò che è colorato e ogni risultato segue.",
    ),
    "Limits: {profile}. Positive slopes run down and to the right going rearward.": (
        "Limites: {profile}. Inclinações positivas descem e vão à direita, indo para trás.",
        "Limiti: {profile}. Le inclinazioni positive scendono e vanno a destra, verso il retro.",
    ),
    "torque at the gearbox output, where given": (
        "torque na saída do câmbio, se dado", "coppia all'uscita del cambio, se data",
    ),
    "speed of the gearbox output, where given": (
        "rotação na saída do câmbio, se dada", "velocità all'uscita del cambio, se data",
    ),
    "line speed over gearbox speed": (
        "rotação da linha sobre a do câmbio", "velocità della linea su quella del cambio",
    ),
    "bearing rating Td": ("capacidade dos rolamentos Td", "capacità dei cuscinetti Td"),
    "Shafts": ("Eixos", "Alberi"),
    "tube, outside diameter": ("tubo, diâmetro externo", "tubo, diametro esterno"),
    "tube, wall": ("tubo, parede", "tubo, spessore"),
    "Young's modulus": ("módulo de elasticidade", "modulo di elasticità"),
    "density": ("densidade", "densità"),
    "polar inertia": ("inércia polar", "inerzia polare"),
    "Duty cycle": ("Ciclo de uso", "Ciclo d'impiego"),
    "share of the life": ("parcela da vida", "quota della durata"),
    "joint angle, where given": ("ângulo da junta, se dado", "angolo del giunto, se dato"),
    "counts for the life (1 or 0)": ("conta para a vida (1 ou 0)", "conta per la durata (1 o 0)"),
    "wear without angle": ("desgaste sem o ângulo", "usura senza l'angolo"),
    "gearbox": ("câmbio", "cambio"),
    "load on the driven wheels at slip": (
        "carga nas rodas trativas no escorregamento", "carico sulle ruote motrici allo slittamento",
    ),
    "States of line {line}": ("Estados da linha {line}", "Stati della linea {line}"),
    "Geometry as the suspension places it: values that may be changed by hand.": (
        "Geometria como a suspensão a posiciona: valores que podem ser mudados à mão.",
        "Geometria come la posiziona la sospensione: valori modificabili a mano.",
    ),
    "Weight on the centre bearings (values of cardan)": (
        "Peso nos mancais centrais (valores do cardan)",
        "Peso sui supporti centrali (valori di cardan)",
    ),
    "Calculation": ("Cálculo", "Calcolo"),
    "Calculation of line {line}": ("Cálculo da linha {line}", "Calcolo della linea {line}"),
    "AE-7's method and closed forms, state by state. Complex numbers stand in two rows: along "
    "position 0 (re) and 90 deg (im).": (
        "Método AE-7 e formas fechadas, estado por estado. Números complexos em duas linhas: na "
        "posição 0 (re) e 90 deg (im).",
        "Metodo AE-7 e forme chiuse, stato per stato. I numeri complessi su due righe: in "
        "posizione 0 (re) e 90 deg (im).",
    ),
    "largest joint angle": ("maior ângulo das juntas", "massimo angolo dei giunti"),
    "as if all joints lay in one plane": (
        "como se todas as juntas estivessem num plano",
        "come se tutti i giunti fossero in un piano",
    ),
    "Torsional acceleration, all joints in one plane": (
        "Aceleração torcional, todas as juntas num plano",
        "Accelerazione torsionale, tutti i giunti in un piano",
    ),
    "couple": ("conjugado", "coppia trasversale"),
    "order 2": ("ordem 2", "ordine 2"),
    "Results": ("Resultados", "Risultati"),
    "Results of line {line}": ("Resultados da linha {line}", "Risultati della linea {line}"),
    "Live: they follow inputs and states. Limits may be changed.": (
        "Vivos: acompanham dados e estados. Os limites podem ser mudados.",
        "Vivi: seguono dati e stati. I limiti si possono cambiare.",
    ),
    "Other results": ("Outros resultados", "Altri risultati"),
    "Exact results of cardan: values, they do not follow the inputs": (
        "Resultados exatos do cardan: valores, não acompanham os dados",
        "Risultati esatti di cardan: valori, non seguono i dati",
    ),
}  # fmt: skip

_EQUATIONS: dict[str, tuple[str, str]] = {
    "Derived from first principles": (
        "Deduzido dos princípios básicos", "Dedotto dai principi primi",
    ),
    "unit vectors along the members before and behind the joint": (
        "vetores unitários dos membros antes e depois da junta",
        "versori dei membri prima e dopo il giunto",
    ),
    "Exact for any layout. View angles combine to it only approximately.": (
        "Exato para qualquer traçado. Os ângulos das vistas só o dão aproximadamente.",
        "Esatto per qualsiasi tracciato. Gli angoli delle viste lo danno solo circa.",
    ),
    "β = atan2(|d₁ × d₂|, d₁ · d₂), held against a lower limit": (
        "β = atan2(|d₁ × d₂|, d₁ · d₂), comparado com um limite inferior",
        "β = atan2(|d₁ × d₂|, d₁ · d₂), confrontato con un limite inferiore",
    ),
    "Needles that never roll wear grooves (false brinelling): a joint needs some angle.": (
        "Agulhas que nunca rolam fazem sulcos (falso brinelling): a junta precisa de algum ângulo.",
        "Rullini che non rotolano scavano solchi (falso brinelling): al giunto serve un angolo.",
    ),
    "φ = atan2(βv, βh), in [0, 360) deg": (
        "φ = atan2(βv, βh), em [0, 360) deg", "φ = atan2(βv, βh), in [0, 360) deg",
    ),
    "change of side and top view slope at the joint": (
        "mudança de inclinação na junta, vista lateral e superior",
        "cambio d'inclinazione al giunto, vista laterale e dall'alto",
    ),
    "βv = side slope behind the joint − side slope before it": (
        "βv = inclinação lateral depois da junta − antes dela",
        "βv = inclinazione laterale dopo il giunto − prima",
    ),
    "βh = top slope behind the joint − top slope before it": (
        "βh = inclinação em planta depois da junta − antes dela",
        "βh = inclinazione in pianta dopo il giunto − prima",
    ),
    "order 2 amplitude, in radians, of pinion rotation less gearbox rotation": (
        "amplitude de ordem 2, em radianos, da rotação do pinhão menos a do câmbio",
        "ampiezza di ordine 2, in radianti, della rotazione del pignone meno quella del cambio",
    ),
    "The angle of the one joint that shakes as much as the whole line; small angles.": (
        "O ângulo da junta única que vibra tanto quanto a linha toda; ângulos pequenos.",
        "L'angolo del solo giunto che vibra quanto l'intera linea; angoli piccoli.",
    ),
    "αR = max over a turn of |αn| at constant gearbox speed": (
        "αR = máx. numa volta de |αn| com o câmbio em rotação constante",
        "αR = max in un giro di |αn| a velocità costante del cambio",
    ),
    "angular acceleration of the pinion": (
        "aceleração angular do pinhão", "accelerazione angolare del pignone",
    ),
    "Kinematic, members rigid. AE-7's approximation is ω² |Σ sk Dk²|.": (
        "Cinemático, membros rígidos. A aproximação da AE-7 é ω² |Σ sk Dk²|.",
        "Cinematico, membri rigidi. L'approssimazione di AE-7 è ω² |Σ sk Dk²|.",
    ),
    "αD = max over a turn of |Σ αj|, j over the shafts, gearbox turning uniformly": (
        "αD = máx. numa volta de |Σ αj|, j nos eixos, câmbio girando uniformemente",
        "αD = max in un giro di |Σ αj|, j sugli alberi, cambio in rotazione uniforme",
    ),
    "αC = max over a turn of |Σ αj|, j over the shafts, pinion turning uniformly": (
        "αC = máx. numa volta de |Σ αj|, j nos eixos, pinhão girando uniformemente",
        "αC = max in un giro di |Σ αj|, j sugli alberi, pignone in rotazione uniforme",
    ),
    "angular acceleration of shaft j": (
        "aceleração angular do eixo j", "accelerazione angolare dell'albero j",
    ),
    "A sum over shafts of equal inertia; `inertia_drive_torque` uses the real ones.": (
        "Soma sobre eixos de inércia igual; `inertia_drive_torque` usa as reais.",
        "Somma su alberi di uguale inerzia; `inertia_drive_torque` usa quelle reali.",
    ),
    "A sum over shafts of equal inertia; `inertia_coast_torque` uses the real ones.": (
        "Soma sobre eixos de inércia igual; `inertia_coast_torque` usa as reais.",
        "Somma su alberi di uguale inerzia; `inertia_coast_torque` usa quelle reali.",
    ),
    "TD = max over a turn of |Σ Jj αj|, gearbox turning uniformly": (
        "TD = máx. numa volta de |Σ Jj αj|, câmbio girando uniformemente",
        "TD = max in un giro di |Σ Jj αj|, cambio in rotazione uniforme",
    ),
    "TC = max over a turn of |Σ Jj αj|, pinion turning uniformly": (
        "TC = máx. numa volta de |Σ Jj αj|, pinhão girando uniformemente",
        "TC = max in un giro di |Σ Jj αj|, pignone in rotazione uniforme",
    ),
    "polar mass moment of inertia of shaft j": (
        "momento polar de inércia do eixo j", "momento d'inerzia polare dell'albero j",
    ),
    "its acceleration": ("sua aceleração", "la sua accelerazione"),
    "U = (ωn,max − ωn,min) / ω₀": ("U = (ωn,máx − ωn,mín) / ω₀", "U = (ωn,max − ωn,min) / ω₀"),
    "pinion speed round the turn": (
        "rotação do pinhão ao longo da volta", "velocità del pignone lungo il giro",
    ),
    "gearbox speed": ("rotação do câmbio", "velocità del cambio"),
    "true angles of the first and last joint": (
        "ângulos reais da primeira e da última junta", "angoli reali del primo e ultimo giunto",
    ),
    "βc = √(βv² + βh²) of a joint, the square-root approximation": (
        "βc = √(βv² + βh²) de uma junta, a aproximação da raiz quadrada",
        "βc = √(βv² + βh²) di un giunto, l'approssimazione a radice quadrata",
    ),
    "view angles at the joint": ("ângulos das vistas na junta", "angoli delle viste al giunto"),
    "true joint angle, rad": ("ângulo real da junta, rad", "angolo reale del giunto, rad"),
    "The largest angle for a speed: 1000 rad/s² is 5.8 deg at 3000 rpm.": (
        "O maior ângulo para uma rotação: 1000 rad/s² são 5,8 deg a 3000 rpm.",
        "L'angolo massimo per una velocità: 1000 rad/s² sono 5,8 deg a 3000 rpm.",
    ),
    "n = n_engine / i_gear": ("n = n_motor / i_marcha", "n = n_motore / i_marcia"),
    "T = min(engine torque, tyre slip torque)": (
        "T = mín(torque do motor, torque de escorregamento do pneu)",
        "T = min(coppia dal motore, coppia di slittamento)",
    ),
    "Loads are computed with the smaller; the joint's size is held against the engine's.": (
        "As cargas usam o menor; o tamanho da junta é comparado com o do motor.",
        "I carichi usano la minore; la taglia del giunto si confronta con quella del motore.",
    ),
    "gear ratio": ("relação da marcha", "rapporto di marcia"),
    "efficiency": ("rendimento", "rendimento"),
    "friction": ("atrito", "aderenza"),
    "load on the driven wheels": ("carga nas rodas trativas", "carico sulle ruote motrici"),
    "static loaded radius": ("raio estático com carga", "raggio statico sotto carico"),
    "axle ratio and efficiency": (
        "relação e rendimento do eixo", "rapporto e rendimento del ponte",
    ),
    "Tb = min(Tm,b i / η, torque at tyre slip as the wheels drive the line)": (
        "Tb = mín(Tm,b i / η, torque de escorregamento com as rodas acionando a linha)",
        "Tb = min(Tm,b i / η, coppia di slittamento con le ruote che trascinano la linea)",
    ),
    "engine brake or retarder torque": (
        "torque do freio-motor ou retardador", "coppia del freno motore o del rallentatore",
    ),
    "What the gears lose helps to brake, so the efficiency divides.": (
        "O que as engrenagens perdem ajuda a frear: o rendimento divide.",
        "Ciò che gli ingranaggi perdono aiuta a frenare: il rendimento divide.",
    ),
    "net engine torque": ("torque líquido do motor", "coppia netta del motore"),
    "lowest gear ratio": ("relação da marcha mais reduzida", "rapporto della marcia più corta"),
    "efficiency, 0.85 manual, 0.80 automatic": (
        "rendimento, 0,85 manual, 0,80 automático", "rendimento, 0,85 manuale, 0,80 automatico",
    ),
    "stall ratio of a converter": (
        "relação de estol do conversor", "rapporto di stallo del convertitore",
    ),
    "ratio and efficiency (0.95) of a transfer case": (
        "relação e rendimento (0,95) da caixa de transferência",
        "rapporto e rendimento (0,95) del ripartitore",
    ),
    "WST = 0.71 W RR / (0.95 AR);  with RR in inches 12 × 0.95 = 11.4": (
        "WST = 0,71 W RR / (0,95 AR);  com RR em polegadas 12 × 0,95 = 11,4",
        "WST = 0,71 W RR / (0,95 AR);  con RR in pollici 12 × 0,95 = 11,4",
    ),
    "axle capacity": ("capacidade do eixo", "capacità dell'asse"),
    "rolling radius": ("raio de rolamento", "raggio di rotolamento"),
    "weight": ("peso", "peso"),
    "load and place of auxiliary axles on air": (
        "carga e posição dos eixos auxiliares pneumáticos",
        "carico e posizione degli assi ausiliari ad aria",
    ),
    "At rest on level ground. A group's axles share its load as the application says.": (
        "Parado em piso plano. Os eixos de um grupo dividem a carga como diz a aplicação.",
        "Fermo in piano. Gli assi di un gruppo si dividono il carico come dice l'applicazione.",
    ),
    "driven shares of the front and rear load": (
        "parcelas trativas da carga dianteira e traseira",
        "quote motrici del carico anteriore e posteriore",
    ),
    "All driven wheels slip at once; no air drag or rolling resistance.": (
        "Todas as rodas trativas escorregam juntas; sem arrasto nem resistência ao rolamento.",
        "Tutte le ruote motrici slittano insieme; senza resistenza dell'aria o al rotolamento.",
    ),
    "z = spring deflection in the state − in the reference state": (
        "z = deflexão da mola no estado − no estado de referência",
        "z = freccia della molla nello stato − nello stato di riferimento",
    ),
    "Up to the frame is positive.": (
        "Positivo em direção ao chassi.", "Positivo verso il telaio.",
    ),
    "ψ = axle torque / wind-up stiffness + pitch of the linkage": (
        "ψ = torque no eixo / rigidez à torção + rotação da guia",
        "ψ = coppia al ponte / rigidezza + beccheggio della guida",
    ),
    "From the reference state; the pinion's nose rising is positive.": (
        "A partir da referência; positivo com o nariz do pinhão subindo.",
        "Dallo stato di riferimento; positivo se il naso del pignone sale.",
    ),
    "max over a turn of T / Tcs, from the engine torque times the shock factor": (
        "máx. numa volta de T / Tcs, do torque do motor vezes o fator de choque",
        "max in un giro di T / Tcs, dalla coppia motore per il fattore d'urto",
    ),
    "functional limit torque of the joint": (
        "torque limite funcional da junta", "coppia limite funzionale del giunto",
    ),
    "Fs = |mean over a turn of the force on the bearing|": (
        "Fs = |média numa volta da força no mancal|",
        "Fs = |media in un giro della forza sul supporto|",
    ),
    "Quasi-static, massless members; gravity and unbalance only where asked for.": (
        "Quase estático, membros sem massa; peso e desbalanceamento só se pedidos.",
        "Quasi statico, membri senza massa; peso e squilibrio solo se richiesti.",
    ),
    "Fd = 0-to-peak along the major axis of the order 2 force ellipse": (
        "Fd = zero a pico no eixo maior da elipse de força de ordem 2",
        "Fd = zero-picco lungo l'asse maggiore dell'ellisse di forza di ordine 2",
    ),
    "Quasi-static, massless members: under a constant torque there is no other order.": (
        "Quase estático, membros sem massa: sob torque constante não há outra ordem.",
        "Quasi statico, membri senza massa: a coppia costante non c'è altro ordine.",
    ),
    "Fp = max over a turn of |F|": ("Fp = máx. numa volta de |F|", "Fp = max in un giro di |F|"),
    "Fj = max over a turn of |force through the joint centre|": (
        "Fj = máx. numa volta de |força pelo centro da junta|",
        "Fj = max in un giro di |forza per il centro del giunto|",
    ),
    "Quasi-static; the needles carry the torque besides.": (
        "Quase estático; as agulhas levam ainda o torque.",
        "Quasi statico; i rullini portano inoltre la coppia.",
    ),
    "FB = FQ − FA,  FA = (o × M − b FQ) / a; max over a turn of the size": (
        "FB = FQ − FA,  FA = (o × M − b FQ) / a; máx. numa volta do módulo",
        "FB = FQ − FA,  FA = (o × M − b FQ) / a; max in un giro del modulo",
    ),
    "FE = FQ − FF,  FF = (o × M − e FQ) / f; max over a turn of the size": (
        "FE = FQ − FF,  FF = (o × M − e FQ) / f; máx. numa volta do módulo",
        "FE = FQ − FF,  FF = (o × M − e FQ) / f; max in un giro del modulo",
    ),
    "moment and force square to the axis on the flange, at the joint centre": (
        "momento e força transversais na flange, no centro da junta",
        "momento e forza trasversali sulla flangia, al centro del giunto",
    ),
    "unit vector from the bearings to the joint": (
        "vetor unitário dos mancais à junta", "versore dai cuscinetti al giunto",
    ),
    "spacing of the bearings": ("distância entre os mancais", "distanza dei cuscinetti"),
    "overhang of the joint centre beyond the nearer one, B": (
        "balanço do centro da junta além do mais próximo, B",
        "sbalzo del centro del giunto oltre il più vicino, B",
    ),
    "overhang of the joint centre beyond the nearer one, E": (
        "balanço do centro da junta além do mais próximo, E",
        "sbalzo del centro del giunto oltre il più vicino, E",
    ),
    "Quasi-static. GWB's catalogue, p. 46, gives two positions of one planar shaft.": (
        "Quase estático. O catálogo GWB, p. 46, dá duas posições de um eixo plano.",
        "Quasi statico. Il catalogo GWB, p. 46, dà due posizioni di un albero piano.",
    ),
    "From the line alone, without the gears' forces. GWB's catalogue: see p. 46.": (
        "Só da linha, sem as forças das engrenagens. Catálogo GWB: ver p. 46.",
        "Dalla sola linea, senza le forze degli ingranaggi. Catalogo GWB: vedi p. 46.",
    ),
    "friction (0.08 coated, 0.11 greased steel)": (
        "atrito (0,08 revestido, 0,11 aço engraxado)",
        "attrito (0,08 rivestito, 0,11 acciaio ingrassato)",
    ),
    "mean spline radius": ("raio médio do estriado", "raggio medio dello scanalato"),
    "Fu = m (G ω) / 2 at each end, e ω = G": (
        "Fu = m (G ω) / 2 em cada extremo, e ω = G", "Fu = m (G ω) / 2 a ogni estremo, e ω = G",
    ),
    "shaft mass": ("massa do eixo", "massa dell'albero"),
    "balance grade, mm/s": ("grau de balanceamento, mm/s", "grado di equilibratura, mm/s"),
    "joint centre distance": (
        "distância entre centros das juntas",
        "distanza dei centri dei giunti",
    ),
    "tube diameters": ("diâmetros do tubo", "diametri del tubo"),
    "steel": ("aço", "acciaio"),
    "Uniform tube pinned at its ends; the line as beams on its bearings stands beside it.": (
        "Tubo uniforme articulado nos extremos; ao lado está a linha como vigas nos mancais.",
        "Tubo uniforme incernierato agli estremi; accanto c'è la linea come travi sui supporti.",
    ),
    "nl = (30/π) Ω, the lowest with det(K − Ω² (M − G)) = 0 that bends the shafts": (
        "nl = (30/π) Ω, a menor com det(K − Ω² (M − G)) = 0 que flete os eixos",
        "nl = (30/π) Ω, la minima con det(K − Ω² (M − G)) = 0 che flette gli alberi",
    ),
    "nb = (30/π) Ω, the lowest with det(K − Ω² (M − G)) = 0 that strains the rubber": (
        "nb = (30/π) Ω, a menor com det(K − Ω² (M − G)) = 0 que deforma a borracha",
        "nb = (30/π) Ω, la minima con det(K − Ω² (M − G)) = 0 che deforma la gomma",
    ),
    "stiffness of tubes and centre bearings": (
        "rigidez de tubos e mancais centrais", "rigidezza di tubi e supporti centrali",
    ),
    "mass of tubes, yokes, spline": (
        "massa de tubos, garfos, luva", "massa di tubi, forcelle, scanalato",
    ),
    "gyroscopic matrix": ("matriz giroscópica", "matrice giroscopica"),
    "Timoshenko beams hinged at the joints, taken as straight, without torque.": (
        "Vigas de Timoshenko articuladas nas juntas, tomadas retas, sem torque.",
        "Travi di Timoshenko incernierate ai giunti, prese diritte, senza coppia.",
    ),
    "Passed at every start and damped by the rubber; joints excite it at half of nb.": (
        "Passada a cada partida e amortecida pela borracha; as juntas a excitam na metade de nb.",
        "Attraversata a ogni avvio e smorzata dalla gomma; i giunti la eccitano a metà di nb.",
    ),
    "n / nc outside 0.42 … 0.58": ("n / nc fora de 0,42 … 0,58", "n / nc fuori da 0,42 … 0,58"),
    "The joints excite twice a turn; matters above about 3 deg of joint angle.": (
        "As juntas excitam duas vezes por volta; importa acima de uns 3 deg de ângulo.",
        "I giunti eccitano due volte per giro; conta sopra circa 3 deg di angolo.",
    ),
    "yield strength": ("limite de escoamento", "carico di snervamento"),
    "amplitude and mean of the shear stress": (
        "amplitude e média da tensão de cisalhamento", "ampiezza e media della tensione di taglio",
    ),
    "amplitude endured about zero": (
        "amplitude suportada em torno de zero", "ampiezza sopportata attorno a zero",
    ),
    "ultimate shear strength": (
        "resistência última ao cisalhamento",
        "resistenza ultima al taglio",
    ),
    "The weld decides: its endurance, not the tube's, belongs here.": (
        "A solda decide: cabe aqui a resistência dela, não a do tubo.",
        "Decide la saldatura: qui va la sua resistenza, non quella del tubo.",
    ),
    "amplitude and mean of the torque": (
        "amplitude e média do torque",
        "ampiezza e media della coppia",
    ),
    "reversing torque endured": ("torque alternado suportado", "coppia alterna sopportata"),
    "pulsating torque endured": ("torque pulsante suportado", "coppia pulsante sopportata"),
    "T/Tdw for reversing, T/Tds for pulsating torque; a straight line between.": (
        "T/Tdw para torque alternado, T/Tds para pulsante; uma reta entre os dois.",
        "T/Tdw per coppia alterna, T/Tds per pulsante; una retta tra le due.",
    ),
    "between the middles of opposite needle rows": (
        "entre os meios das carreiras de agulhas opostas", "tra le mezzerie dei rullini opposti",
    ),
    "speed, rpm": ("rotação, rpm", "velocità, rpm"),
    "joint angle, not below 3 deg": (
        "ângulo da junta, não menor que 3 deg", "angolo del giunto, non sotto 3 deg",
    ),
    "torque for 5000 h at 100 rpm and 3 deg": (
        "torque para 5000 h a 100 rpm e 3 deg", "coppia per 5000 h a 100 rpm e 3 deg",
    ),
    "shares of a duty cycle": ("parcelas do ciclo de uso", "quote del ciclo d'impiego"),
    "B10 life of the needle bearings, greased.": (
        "Vida B10 dos rolamentos de agulhas, engraxados.",
        "Durata B10 dei cuscinetti a rullini, ingrassati.",
    ),
    "n against the joint's own limit": (
        "n contra o limite da própria junta", "n contro il limite del giunto stesso",
    ),
    "ΔL = length of the last shaft − its length in the reference state": (
        "ΔL = comprimento do último eixo − o do estado de referência",
        "ΔL = lunghezza dell'ultimo albero − quella nello stato di riferimento",
    ),
    "s = min(plunge + ΔL, draw − ΔL)": (
        "s = mín(entrada + ΔL, saída − ΔL)", "s = min(entrata + ΔL, uscita − ΔL)",
    ),
    "travel from the installed place, in and out": (
        "curso a partir da posição instalada, para dentro e para fora",
        "corsa dalla posizione installata, in entrata e in uscita",
    ),
    "c = distance of shaft axis and obstacle axis − their radii": (
        "c = distância entre o eixo e o eixo do obstáculo − os raios",
        "c = distanza tra asse dell'albero e asse dell'ostacolo − i raggi",
    ),
    "slope of the spring's table at the state": (
        "inclinação da tabela da mola no estado", "pendenza della tabella della molla nello stato",
    ),
    "mass the spring carries": ("massa que a mola carrega", "massa portata dalla molla"),
    "n / nr,  nr = ωi / order": ("n / nr,  nr = ωi / ordem", "n / nr,  nr = ωi / ordine"),
    "nearest speed of a gear's range": (
        "rotação mais próxima na faixa de uma marcha",
        "velocità più vicina nel campo di una marcia",
    ),
    "torsional natural frequency": (
        "frequência natural torcional", "frequenza propria torsionale",
    ),
    "The joints excite orders 2 and 4. Frequencies of the line with its joints straight.": (
        "As juntas excitam as ordens 2 e 4. Frequências da linha com as juntas retas.",
        "I giunti eccitano gli ordini 2 e 4. Frequenze della linea con i giunti diritti.",
    ),
    "what half a turn makes of small motions about the forced one": (
        "o que meia volta faz dos pequenos movimentos em torno do forçado",
        "ciò che mezzo giro fa dei piccoli moti attorno a quello forzato",
    ),
    "Above 0 the line shakes itself up; at the speeds nearest to the zones.": (
        "Acima de 0 a linha se autoexcita; nas rotações mais próximas das zonas.",
        "Sopra 0 la linea si autoeccita; alle velocità più vicine alle zone.",
    ),
    "what half a turn makes of small lateral motions of a hung shaft": (
        "o que meia volta faz dos pequenos movimentos laterais de um eixo suspenso",
        "ciò che mezzo giro fa dei piccoli moti laterali di un albero sospeso",
    ),
    "One shaft on its own rubber bearing, under the torque of the gear.": (
        "Um eixo no seu próprio mancal de borracha, sob o torque da marcha.",
        "Un albero sul proprio supporto in gomma, sotto la coppia della marcia.",
    ),
    "Δσ = |σ2 − σ1| of each rainflow cycle": (
        "Δσ = |σ2 − σ1| de cada ciclo rainflow", "Δσ = |σ2 − σ1| di ogni ciclo rainflow",
    ),
    "reversals that bound the cycle": (
        "reversões que limitam o ciclo", "inversioni che delimitano il ciclo",
    ),
    "What never closes, the residue, holds the largest cycle: say how it is counted.": (
        "O que nunca fecha, o resíduo, contém o maior ciclo: diga como é contado.",
        "Ciò che non si chiude, il residuo, contiene il ciclo maggiore: dire come si conta.",
    ),
    "counted cycles": ("ciclos contados", "cicli contati"),
    "cycles to failure at their amplitude and mean": (
        "ciclos até a falha na sua amplitude e média",
        "cicli a rottura alla loro ampiezza e media",
    ),
    "Failure at 1 by Miner; at 0.3 to 0.5 in careful practice under service loads.": (
        "Falha em 1 por Miner; em 0,3 a 0,5 na prática cautelosa sob cargas de serviço.",
        "Rottura a 1 per Miner; a 0,3-0,5 nella pratica prudente sotto carichi di servizio.",
    ),
    "length of the recording": ("duração da gravação", "durata della registrazione"),
    "damage at failure": ("dano na falha", "danno a rottura"),
    "its damage": ("seu dano", "il suo danno"),
    "Of a vehicle that goes on driving what was recorded.": (
        "De um veículo que segue rodando o que foi gravado.",
        "Di un veicolo che continua a percorrere quanto registrato.",
    ),
    "damage": ("dano", "danno"),
    "scale of the stress": ("escala da tensão", "scala della tensione"),
    "A gauge that reads 1 % high overstates damage by κ %.": (
        "Um extensômetro que lê 1 % a mais exagera o dano em κ %.",
        "Un estensimetro che legge l'1 % in più sovrastima il danno del κ %.",
    ),
    "φi = Σ |S|! (G−1−|S|)! / G! · (D(S ∪ i) − D(S)) / D, over S without i": (
        "φi = Σ |S|! (G−1−|S|)! / G! · (D(S ∪ i) − D(S)) / D, nos S sem i",
        "φi = Σ |S|! (G−1−|S|)! / G! · (D(S ∪ i) − D(S)) / D, sugli S senza i",
    ),
    "number of causes": ("número de causas", "numero di cause"),
    "a choice of the other causes": (
        "uma escolha das outras causas", "una scelta delle altre cause",
    ),
    "damage of the sum of their stresses": (
        "dano da soma das suas tensões", "danno della somma delle loro tensioni",
    ),
    "Damage is not additive; these shares sum to 1. Negative: the cause spares the part.": (
        "O dano não é aditivo; estas parcelas somam 1. Negativo: a causa poupa a peça.",
        "Il danno non è additivo; queste quote sommano a 1. Negativo: la causa risparmia il pezzo.",
    ),
    "β = min |u| with g(u) = 0,  Pf ≈ Φ(−β)": (
        "β = mín |u| com g(u) = 0,  Pf ≈ Φ(−β)", "β = min |u| con g(u) = 0,  Pf ≈ Φ(−β)",
    ),
    "the scattered quantities as standard normals": (
        "as grandezas dispersas como normais padrão",
        "le grandezze disperse come normali standard",
    ),
    "limit state": ("estado limite", "stato limite"),
    "Exact where g is linear in u, as for lognormals under one S-N line.": (
        "Exato onde g é linear em u, como para lognormais sob uma só reta S-N.",
        "Esatto dove g è lineare in u, come per lognormali sotto una sola retta S-N.",
    ),
    "1.0 to 1.3 Hz is comfortable.": (
        "De 1,0 a 1,3 Hz é confortável.", "Da 1,0 a 1,3 Hz è confortevole.",
    ),
}  # fmt: skip

_BRACKET: dict[str, tuple[str, str]] = {
    "The bracket": ("O suporte", "La staffa"),
    "The bracket of bearing {bearing}": (
        "O suporte do mancal {bearing}", "La staffa del supporto {bearing}",
    ),
    "--bracket needs one file, and --html or --pdf to write to": (
        "--bracket pede um só arquivo, e --html ou --pdf onde escrever",
        "--bracket richiede un solo file, e --html o --pdf in cui scrivere",
    ),
    "original": ("original", "originale"),
    "reinforced": ("reforçado", "rinforzata"),
    "Original and reinforced": ("Original e reforçado", "Originale e rinforzata"),
    "mass, kg": ("massa, kg", "massa, kg"),
    "stiffness at the bearing along {axis}, N/mm": (
        "rigidez no mancal ao longo de {axis}, N/mm", "rigidezza al supporto lungo {axis}, N/mm",
    ),
    "frequency {mode}, loaded, Hz": (
        "frequência {mode}, carregado, Hz", "frequenza {mode}, caricata, Hz",
    ),
    "first frequency by itself, Hz": (
        "primeira frequência, sozinho, Hz", "prima frequenza, da sola, Hz",
    ),
    "highest stress at a hot spot, MPa": (
        "maior tensão em um ponto crítico, MPa", "massima tensione in un punto critico, MPa",
    ),
    "largest damage of a turn of the shaft": (
        "maior dano de uma volta do eixo", "massimo danno di un giro dell'albero",
    ),
    "{name}: no order 1, 2 or 4 meets a natural frequency within the speed range.": (
        "{name}: nenhuma ordem 1, 2 ou 4 encontra uma frequência natural na faixa de rotação.",
        "{name}: nessun ordine 1, 2 o 4 incontra una frequenza propria nel campo di velocità.",
    ),
    "{name}: order {order} meets frequency {mode}, {frequency} Hz, at {speed} rpm.": (
        "{name}: a ordem {order} encontra a frequência {mode}, {frequency} Hz, a {speed} rpm.",
        "{name}: l'ordine {order} incontra la frequenza {mode}, {frequency} Hz, a {speed} rpm.",
    ),
    "Stresses in MPa: {name}": ("Tensões em MPa: {name}", "Tensioni in MPa: {name}"),
    "case": ("caso", "caso"),
    "tension": ("tração", "trazione"),
    "compression": ("compressão", "compressione"),
    "hot spot": ("ponto crítico", "punto critico"),
    "Hot spots, mm from the bearing's centre: {name}": (
        "Pontos críticos, mm a partir do centro do mancal: {name}",
        "Punti critici, mm dal centro del supporto: {name}",
    ),
    "Gauges, microstrain: {name}": (
        "Extensômetros, microdeformação: {name}", "Estensimetri, microdeformazioni: {name}",
    ),
    "Damage and life at the worst hot spot: {name}": (
        "Dano e vida no pior ponto crítico: {name}",
        "Danno e vita nel punto critico peggiore: {name}",
    ),
    "damage per turn": ("dano por volta", "danno per giro"),
    "damage per hour": ("dano por hora", "danno per ora"),
    "hours to failure": ("horas até a falha", "ore al cedimento"),
    "duty cycle": ("ciclo de serviço", "ciclo di servizio"),
    "static": ("estático", "statico"),
    "combined": ("combinado", "combinato"),
    "peak": ("pico", "picco"),
    "Stresses leave out what lies within 1.5 thicknesses of a sharp edge or a clamp, where "
    "they depend on the mesh; H are solved again, finer, with their estimated error.": (
        "As tensões deixam de fora o que está a menos de 1,5 espessura de uma aresta viva ou de "
        "uma fixação, onde dependem da malha; H são recalculados, mais finos, com o erro estimado.",
        "Le tensioni escludono ciò che dista meno di 1,5 spessori da uno spigolo vivo o da un "
        "fissaggio, dove dipendono dalla mesh; gli H sono ricalcolati, più fini, con l'errore "
        "stimato.",
    ),
    "Loads are quasi-static: right below the natural frequencies.": (
        "As cargas são quase estáticas: corretas abaixo das frequências naturais.",
        "I carichi sono quasi statici: corretti al di sotto delle frequenze proprie.",
    ),
    "Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress by Goodman.": (
        "Dano: rainflow e Miner, 2k - 1 além do joelho, tensão média por Goodman.",
        "Danno: rainflow e Miner, 2k - 1 oltre il ginocchio, tensione media secondo Goodman.",
    ),
    "Damage: rainflow and Miner, 2k - 1 beyond the knee, mean stress not counted.": (
        "Dano: rainflow e Miner, 2k - 1 além do joelho, tensão média não considerada.",
        "Danno: rainflow e Miner, 2k - 1 oltre il ginocchio, tensione media non considerata.",
    ),
    "Stress where it is worst: {case}": (
        "Tensão onde é pior: {case}", "Tensione dove è peggiore: {case}",
    ),
    "The bracket deformed under {case}, coloured by von Mises stress; the highest, {stress} MPa, "
    "is at x {x}, y {y}, z {z} mm from the bearing's centre.": (
        "O suporte deformado sob {case}, colorido pela tensão de von Mises; a maior, {stress} MPa, "
        "está em x {x}, y {y}, z {z} mm a partir do centro do mancal.",
        "La staffa deformata sotto {case}, colorata secondo la tensione di von Mises; la massima, "
        "{stress} MPa, è in x {x}, y {y}, z {z} mm dal centro del supporto.",
    ),
    "deformed {times} times": ("deformação ampliada {times} vezes", "deformata {times} volte"),
    "von Mises stress, MPa": ("tensão de von Mises, MPa", "tensione di von Mises, MPa"),
    "shape": ("forma", "forma"),
    "deformation": ("deformação", "deformazione"),
    "This browser shows no WebGL.": (
        "Este navegador não mostra WebGL.", "Questo browser non mostra WebGL.",
    ),
    "blue 0 to red {top} MPa, von Mises": (
        "azul 0 a vermelho {top} MPa, von Mises", "blu 0 a rosso {top} MPa, von Mises",
    ),
}  # fmt: skip

_PROGRESS: dict[str, tuple[str, str]] = {
    "looking for corrections": ("procurando correções", "ricerca di correzioni"),
    "writing {file}": ("escrevendo {file}", "scrittura di {file}"),
}

_VIBRATION: dict[str, tuple[str, str]] = {
    "Vibration and stability": ("Vibração e estabilidade", "Vibrazione e stabilità"),
    "Vibration: {verdict} ({counts}).": (
        "Vibração: {verdict} ({counts}).", "Vibrazione: {verdict} ({counts}).",
    ),
    "Torsion": ("Torção", "Torsione"),
    "axle inertia": ("inércia do eixo", "inerzia del ponte"),
    "axle torsional stiffness": (
        "rigidez torcional do eixo", "rigidezza torsionale del ponte",
    ),
    "gearbox inertia": ("inércia do câmbio", "inerzia del cambio"),
    "gearbox torsional stiffness": (
        "rigidez torcional do câmbio", "rigidezza torsionale del cambio",
    ),
    "damping ratio of the first mode": (
        "fator de amortecimento do primeiro modo", "rapporto di smorzamento del primo modo",
    ),
    "Given: {values}.": ("Dado: {values}.", "Dato: {values}."),
    "Assumed: {values}.": ("Suposto: {values}.", "Ipotizzato: {values}."),
    "gearbox turning uniformly": (
        "câmbio girando uniformemente", "cambio in rotazione uniforme",
    ),
    "gearbox {inertia} kg m² on {stiffness} N m/rad": (
        "câmbio {inertia} kg m² sobre {stiffness} N m/rad",
        "cambio {inertia} kg m² su {stiffness} N m/rad",
    ),
    "axle {inertia} kg m²": ("eixo {inertia} kg m²", "ponte {inertia} kg m²"),
    "axle on {stiffness} N m/rad": (
        "eixo sobre {stiffness} N m/rad", "ponte su {stiffness} N m/rad",
    ),
    "pinion rigid to the axle": ("pinhão rígido com o eixo", "pignone rigido con il ponte"),
    "damping ratio {ratio}": (
        "fator de amortecimento {ratio}", "rapporto di smorzamento {ratio}",
    ),
    "loss factor of the rubber {factor}": (
        "fator de perda da borracha {factor}", "fattore di perdita della gomma {factor}",
    ),
    "How far each range of speed stays from resonances and zones": (
        "Quanto cada faixa de rotação fica longe de ressonâncias e zonas",
        "Quanto ogni campo di velocità resta lontano da risonanze e zone",
    ),
    "0 % runs through it; − stays below its speed, + above.": (
        "0 % passa por ela; − fica abaixo da sua rotação, + acima.",
        "0 % la attraversa; − resta sotto la sua velocità, + sopra.",
    ),
    "resonance or zone": ("ressonância ou zona", "risonanza o zona"),
    "at [rpm]": ("a [rpm]", "a [rpm]"),
    "top speed": ("rotação máxima", "velocità massima"),
    "mode {mode}, order {order}": ("modo {mode}, ordem {order}", "modo {mode}, ordine {order}"),
    "zone of mode {mode}": ("zona do modo {mode}", "zona del modo {mode}"),
    "zone of modes {mode} + {other}": (
        "zona dos modos {mode} + {other}", "zona dei modi {mode} + {other}",
    ),
    "Growth of vibrations, where it is worst": (
        "Crescimento das vibrações, onde é pior", "Crescita delle vibrazioni, dove è peggiore",
    ),
    "Speeds against torsional frequencies": (
        "Rotações e frequências torcionais", "Velocità e frequenze torsionali",
    ),
    "frequency [Hz]": ("frequência [Hz]", "frequenza [Hz]"),
    "mode {mode}, {frequency} Hz": ("modo {mode}, {frequency} Hz", "modo {mode}, {frequency} Hz"),
    "Bars: speeds of each gear. Circles: resonances. Triangles: parametric zones, red where "
    "motions grow.": (
        "Barras: rotações de cada marcha. Círculos: ressonâncias. Triângulos: zonas "
        "paramétricas, vermelhas onde os movimentos crescem.",
        "Barre: velocità di ogni marcia. Cerchi: risonanze. Triangoli: zone parametriche, rosse "
        "dove i moti crescono.",
    ),
    "Torque of forced torsional vibration": (
        "Torque da vibração torcional forçada", "Coppia della vibrazione torsionale forzata",
    ),
    "torque, 0-to-peak [N·m]": ("torque, 0 a pico [N·m]", "coppia, 0-picco [N·m]"),
    "Largest of all states and places in the line.": (
        "O maior de todos os estados e lugares da linha.",
        "Il massimo di tutti gli stati e i punti della linea.",
    ),
}  # fmt: skip

_PAPER: dict[str, tuple[str, str]] = {
    "Letters": ("Letras", "Lettere"),
    "{sign} stands for letters that this document's fonts lack: {letters}.": (
        "{sign} está no lugar de letras que faltam nas fontes deste documento: {letters}.",
        "{sign} sta per lettere che mancano nei caratteri di questo documento: {letters}.",
    ),
}  # fmt: skip

WORDS: dict[str, tuple[str, str]] = {
    **_VERDICTS, **_CHANGES, **_STORY, **_PARTS, **_INPUTS, **_DRAWINGS, **_PLOTS, **_WORKBOOK,
    **_EQUATIONS, **_BRACKET, **_VIBRATION, **_PROGRESS, **_PAPER,
}  # fmt: skip
"""English text to Portuguese and Italian."""
